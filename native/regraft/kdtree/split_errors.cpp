#include "regraft/kdtree/split_errors.h"

#include <algorithm>
#include <utility>

#include "regraft/kdtree/sah_scan.h"

namespace regraft::kdtree {

namespace {

/// Lets all scans choose where the sweep has chosen.
class Comparison {
 public:
  Comparison(const Config& config, std::span<const ScanConfig> scans)
      : config_(config), scans_(scans), sweep_(config.cost), errors_(scans.size()) {}

  void at(const Pending& node) {
    entries_.clear();
    for (const HierarchyEntry& e : node.list) entries_.push_back({e.box, e.weight});
    const ChildProbability probability(node.voxel, config_.origins.metric, config_.origins.origins);
    const EntrySummary summary = summarise(entries_);
    if (empty_cut(summary, probability, config_.cost).found()) return;
    const double exact = sweep_.find(entries_, probability).cost;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      if (entries_.size() <= scans_[i].exact_below) continue;
      scan_.set(config_.cost, scans_[i]);
      const Split split = scan_.find(entries_, probability);
      const double chosen = std::min(split.cost, config_.cost.intersect * summary.weight);
      add(errors_[i], {chosen / exact - 1.0, std::max(0.0, chosen / split.lower_bound - 1.0)},
          split.samples);
    }
  }

  std::vector<SplitErrors> means() && {
    for (SplitErrors& e : errors_) {
      if (e.nodes == 0) continue;
      for (double* sum : {&e.mean_excess, &e.mean_certificate, &e.mean_samples})
        *sum /= double(e.nodes);
    }
    return std::move(errors_);
  }

 private:
  struct Error {
    double excess, certificate;
  };
  static void add(SplitErrors& to, const Error& error, std::uint32_t samples) {
    ++to.nodes;
    to.worst_excess = std::max(to.worst_excess, error.excess);
    to.mean_excess += error.excess;
    to.worst_certificate = std::max(to.worst_certificate, error.certificate);
    to.mean_certificate += error.certificate;
    to.mean_samples += samples;
  }

  const Config& config_;
  std::span<const ScanConfig> scans_;
  SahSweep sweep_;
  SahScan scan_;
  std::vector<SplitEntry> entries_;
  std::vector<SplitErrors> errors_;  ///< means are sums until the end
};

}  // namespace

std::vector<SplitErrors> split_errors(const HierarchyView& view, const Config& config,
                                      std::span<const ScanConfig> scans) {
  std::size_t fewest = std::size_t(-1);
  for (const ScanConfig& scan : scans) fewest = std::min(fewest, scan.exact_below);
  Config exact = config;
  exact.scan = exact.hierarchy = false;
  const SeededBuilder builder(view, exact);
  Comparison comparison(exact, scans);
  std::vector<Pending> open;
  open.push_back(builder.root());
  while (!open.empty()) {
    const Pending node = std::move(open.back());
    open.pop_back();
    if (node.list.size() <= fewest) continue;
    Built built = builder.build(node);
    if (built.axis < 0) continue;
    comparison.at(node);
    for (Pending& child : built.children) open.push_back(std::move(child));
  }
  return std::move(comparison).means();
}

}  // namespace regraft::kdtree
