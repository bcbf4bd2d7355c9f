#include "regraft/kdtree/seeded_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "regraft/kdtree/refinement.h"
#include "regraft/kdtree/sah_scan.h"
#include "regraft/kdtree/sah_sweep.h"

namespace regraft::kdtree {

namespace {

double total_weight(std::span<const HierarchyEntry> list) {
  double sum = 0.0;
  for (const HierarchyEntry& e : list) sum += e.weight;
  return sum;
}

void sort_refs(std::vector<PrimRef>& prims) {
  std::sort(prims.begin(), prims.end(), [](const PrimRef& a, const PrimRef& b) {
    return a.object != b.object ? a.object < b.object : a.prim < b.prim;
  });
}

/// The best split of a node, or none; opens entries until it can tell.
class Chooser {
 public:
  Chooser(const HierarchyView& view, const Config& config, Refinement& list, const Aabb& voxel)
      : config_(config),
        list_(list),
        voxel_(voxel),
        limit_(5 * (std::size_t(config.refine_to) + view.fan_out())),
        step_(view.fan_out()),
        sweep_(config.cost),
        scan_(config.cost, config.precision) {}

  Split choose() {
    Split best = evaluate();
    if (best.found() && list_.size() < limit_ &&
        list_.open_straddlers(best, std::min(room(), std::size_t(config_.open_straddlers))))
      best = evaluate();
    while (!best.found() && list_.can_open() && list_.size() < limit_) {
      list_.open_until(std::min(limit_, 2 * list_.size() + step_));
      best = evaluate();
    }
    return best;
  }

 private:
  /// Entries that may be opened without the list outgrowing its limit.
  std::size_t room() const { return (limit_ - list_.size() + step_ - 1) / step_; }

  Split evaluate() {
    entries_.clear();
    list_.for_each([&](const HierarchyEntry& e) { entries_.push_back({e.box, e.weight}); });
    const ChildProbability probability(voxel_);
    return config_.scan ? scan_.find(entries_, probability) : sweep_.find(entries_, probability);
  }

  const Config& config_;
  Refinement& list_;
  const Aabb& voxel_;
  const std::size_t limit_;
  const std::size_t step_;
  SahSweep sweep_;
  SahScan scan_;
  std::vector<SplitEntry> entries_;
};

/// Hands the entries of a node to its two sides; those across the plane go to both.
class Sift {
 public:
  Sift(const HierarchyView& view, const Aabb& voxel, const Split& split)
      : view_(view), split_(split) {
    side_[0] = side_[1] = voxel;
    side_[0].hi[split.axis] = side_[1].lo[split.axis] = split.position;
  }

  const Aabb& voxel(int side) const { return side_[side]; }

  void operator()(const HierarchyEntry& entry, Pending (&to)[2]) const {
    const int axis = split_.axis;
    const bool left = entry.box.lo[axis] < split_.position;
    const bool right = entry.box.hi[axis] > split_.position;
    if (!left && !right) return to[split_.flat_left ? 0 : 1].list.push_back(entry);
    if (left != right) return to[right].list.push_back(entry);
    for (int s = 0; s < 2; ++s) {
      HierarchyEntry part = entry;
      if (entry.primitive())
        part.box = view_.clip(entry, side_[s]);
      else
        (s == 0 ? part.box.hi : part.box.lo)[axis] = split_.position;
      if (!part.box.empty()) to[s].list.push_back(part);
    }
  }

 private:
  const HierarchyView& view_;
  Split split_;
  Aabb side_[2];
};

Built make_leaf(const HierarchyView& view, Refinement& list, const Aabb& voxel) {
  list.open_until(std::size_t(-1));
  Built result;
  list.for_each([&](const HierarchyEntry& e) {
    if (!view.clip(e, voxel).empty()) result.prims.push_back({e.object, e.node});
  });
  sort_refs(result.prims);
  return result;
}

Built make_inner(const HierarchyView& view, const std::vector<HierarchyEntry>& list,
                 const Pending& node, const Split& split) {
  Built result;
  result.axis = split.axis;
  result.position = split.position;
  const Sift sift(view, node.voxel, split);
  for (const HierarchyEntry& e : list) sift(e, result.children);
  const double weight[2] = {result.children[0].weight(), result.children[1].weight()};
  const double sum = std::max(1.0, weight[0] + weight[1]);
  for (int s = 0; s < 2; ++s) {
    result.children[s].voxel = sift.voxel(s);
    result.children[s].depth = node.depth + 1;
    result.children[s].budget = node.budget * weight[s] / sum;
  }
  return result;
}

}  // namespace

std::string_view name(const Config& config) {
  static constexpr std::array<std::string_view, 8> names{
      "eager",     "lazy",           "scan",           "lazy+scan",
      "hierarchy", "lazy+hierarchy", "scan+hierarchy", "lazy+scan+hierarchy"};
  return names[(config.lazy ? 1u : 0u) + (config.scan ? 2u : 0u) + (config.hierarchy ? 4u : 0u)];
}

double Pending::weight() const {
  return total_weight(list);
}

SeededBuilder::SeededBuilder(const HierarchyView& view, const Config& config)
    : view_(view), config_(config) {
  std::vector<HierarchyEntry> top;
  view.top(top);
  for (const HierarchyEntry& e : top) bounds_.extend(e.box);
  weight_ = total_weight(top);
  max_depth_ = std::min(deepest, std::uint32_t(8.0 + 1.3 * std::log2(std::max(1.0, weight_))));
}

Pending SeededBuilder::root() const {
  return seed(bounds_, 0, config_.references_per_primitive * weight_ + 64.0);
}

Pending SeededBuilder::seed(const Aabb& voxel, std::uint32_t depth, double budget) const {
  Pending node{voxel, {}, budget, depth};
  view_.top(node.list);
  std::erase_if(node.list, [&](HierarchyEntry& e) { return e.box.empty() || !cut(e.box, voxel); });
  if (config_.hierarchy) return node;
  Refinement all(view_, config_.refine, node);
  all.open_until(std::size_t(-1));
  return {voxel, all.take(), budget, depth};
}

Built SeededBuilder::build(const Pending& node) const {
  Refinement list(view_, config_.refine, node);
  list.open_until(config_.refine_to);
  Split split;
  if (node.depth < max_depth_ && list.weight() <= node.budget)
    split = Chooser(view_, config_, list, node.voxel).choose();
  return split.found() ? make_inner(view_, list.take(), node, split)
                       : make_leaf(view_, list, node.voxel);
}

}  // namespace regraft::kdtree
