#pragma once

#include <span>
#include <vector>

#include "regraft/kdtree/scan_segments.h"

namespace regraft::kdtree {

/// Divides the segments that may hold a plane cheaper than the best known, lowest bound first,
/// until that plane is proven to cost at most 1 + epsilon times the least possible, or none to
/// beat the leaf. Keeps its working memory.
class ScanRefinement {
 public:
  struct Goal {
    double epsilon;
    double leaf;
    bool reached(double best, double bound) const {
      return best <= (1.0 + epsilon) * bound || bound >= leaf;
    }
  };
  /// Starts anew with the segments between uniform samples.
  void clear() { segments_.clear(); }
  void add(const ScanSegment& segment) { segments_.push_back(segment); }
  /// Improves `best` and sets its lower bound.
  void run(Split& best, const SplitProblem& problem, const Goal& goal,
           std::span<const SplitEntry> entries, const EventBins& bins);

 private:
  struct Extent {
    double lo, hi;
  };
  static Extent extent_of(std::span<const SplitEvent> events);
  double lower_bound() const;
  void collect(std::span<const SplitEntry> entries, const EventBins& bins);
  void divide(const SplitProblem& problem, const ScanSegment& segment, const Extent& extent);

  std::vector<ScanSegment> segments_;  ///< a heap while running
  std::vector<SplitEvent> events_, divided_;
  std::vector<std::uint32_t> owners_;
};

}  // namespace regraft::kdtree
