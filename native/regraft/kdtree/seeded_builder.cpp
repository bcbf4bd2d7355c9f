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

bool all_primitives(std::span<const HierarchyEntry> list) {
  return std::all_of(list.begin(), list.end(), [](const auto& e) { return e.primitive(); });
}

/// Finds splits. Keeps its working memory: one for each thread.
class Splitter {
 public:
  /// What one split is to be found for.
  struct Task {
    const Config& config;
    const Aabb& voxel;
    std::span<const HierarchyEntry> list;
  };

  Split find(const Task& task) {
    entries_.clear();
    entries_.reserve(task.list.size());
    for (const HierarchyEntry& e : task.list) entries_.push_back({e.box, e.weight});
    const OriginChoice& origins = task.config.origins;
    const ChildProbability probability(task.voxel, origins.metric, origins.origins);
    if (!task.config.scan) {
      sweep_.set(task.config.cost);
      return sweep_.find(entries_, probability);
    }
    scan_.set(task.config.cost, task.config.precision);
    return scan_.find(entries_, probability);
  }

 private:
  SahSweep sweep_;
  SahScan scan_;
  std::vector<SplitEntry> entries_;
};

thread_local Splitter splitter;
thread_local std::vector<std::uint8_t> side_buffer;

/// The best split of a list that can be opened further, or none; opens entries until it can tell.
class Chooser {
 public:
  Chooser(const HierarchyView& view, const Config& config, Refinement& list, const Aabb& voxel)
      : config_(config),
        list_(list),
        voxel_(voxel),
        limit_(5 * (std::size_t(config.refine_to) + view.fan_out())),
        step_(view.fan_out()) {}

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

  Split evaluate() { return splitter.find({config_, voxel_, list_.compacted()}); }

  const Config& config_;
  Refinement& list_;
  const Aabb& voxel_;
  const std::size_t limit_;
  const std::size_t step_;
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

  /// Keeps what goes where in `sides`.
  void run(std::span<const HierarchyEntry> list, std::vector<std::uint8_t>& sides,
           Pending (&to)[2]) const {
    std::size_t count[2] = {0, 0};
    sides.resize(list.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
      sides[i] = sides_of(list[i]);
      count[0] += sides[i] & 1u;
      count[1] += sides[i] >> 1;
    }
    for (const int s : {0, 1}) to[s].list.reserve(count[s]);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (sides[i] == 3)
        part(list[i], to);
      else
        add(list[i], to[sides[i] >> 1]);
    }
  }

 private:
  /// Bit 0: lower side, bit 1: upper.
  std::uint8_t sides_of(const HierarchyEntry& e) const {
    const bool lower = e.box.lo[split_.axis] < split_.position;
    const bool upper = e.box.hi[split_.axis] > split_.position;
    if (!lower && !upper) return split_.flat_left ? 1 : 2;
    return std::uint8_t(lower ? 1 : 0) | std::uint8_t(upper ? 2 : 0);
  }

  static void add(const HierarchyEntry& e, Pending& to) {
    to.weight += e.weight;
    to.list.push_back(e);
  }

  void part(const HierarchyEntry& e, Pending (&to)[2]) const {
    Aabb box[2] = {e.box, e.box};
    if (e.primitive())
      view_.clip_sides(e, split_.axis, split_.position, box);
    else
      box[0].hi[split_.axis] = box[1].lo[split_.axis] = split_.position;
    for (const int s : {0, 1}) {
      if (box[s].empty()) continue;
      add(e, to[s]);
      to[s].list.back().box = box[s];
    }
  }

  const HierarchyView& view_;
  Split split_;
  Aabb side_[2];
};

Built make_leaf(std::span<const HierarchyEntry> list) {
  Built result;
  result.prims.reserve(list.size());
  for (const HierarchyEntry& e : list) result.prims.push_back({e.object, e.node});
  std::sort(result.prims.begin(), result.prims.end(), [](const PrimRef& a, const PrimRef& b) {
    return a.object != b.object ? a.object < b.object : a.prim < b.prim;
  });
  return result;
}

}  // namespace

std::string_view name(const Config& config) {
  static constexpr std::array<std::string_view, 8> names{
      "eager",     "lazy",           "scan",           "lazy+scan",
      "hierarchy", "lazy+hierarchy", "scan+hierarchy", "lazy+scan+hierarchy"};
  return names[(config.lazy ? 1u : 0u) + (config.scan ? 2u : 0u) + (config.hierarchy ? 4u : 0u)];
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
  return seed(bounds_, 0, allowed(weight_));
}

Pending SeededBuilder::seed(const Aabb& voxel, std::uint32_t depth, double budget) const {
  Pending node{voxel, {}, budget, 0.0, depth};
  view_.top(node.list);
  std::erase_if(node.list, [&](HierarchyEntry& e) { return e.box.empty() || !cut(e.box, voxel); });
  if (!config_.hierarchy) {
    Refinement all(view_, config_.refine, node);
    all.open_until(std::size_t(-1));
    const auto list = all.compacted();
    node.list.assign(list.begin(), list.end());
  }
  node.weight = total_weight(node.list);
  return node;
}

Built SeededBuilder::make_inner(std::span<const HierarchyEntry> list, const Pending& node,
                                const Split& split) const {
  Built result;
  result.axis = split.axis;
  result.position = split.position;
  const Sift sift(view_, node.voxel, split);
  sift.run(list, side_buffer, result.children);
  const double sum = std::max(1.0, result.children[0].weight + result.children[1].weight);
  const double budget = node.budget == Pending::by_weight ? allowed(sum) : node.budget;
  for (int s = 0; s < 2; ++s) {
    result.children[s].voxel = sift.voxel(s);
    result.children[s].depth = node.depth + 1;
    result.children[s].budget = budget * result.children[s].weight / sum;
  }
  return result;
}

bool SeededBuilder::surely_leaf(const Pending& node) const {
  return !may_split(node, node.weight) && all_primitives(node.list);
}

Built SeededBuilder::build(const Pending& node) const {
  if (all_primitives(node.list)) {
    Split split;
    if (may_split(node, node.weight)) split = splitter.find({config_, node.voxel, node.list});
    return split.found() ? make_inner(node.list, node, split) : make_leaf(node.list);
  }
  Refinement list(view_, config_.refine, node);
  list.open_until(config_.refine_to);
  Split split;
  if (may_split(node, list.weight())) split = Chooser(view_, config_, list, node.voxel).choose();
  if (split.found()) return make_inner(list.compacted(), node, split);
  list.open_until(std::size_t(-1));
  return make_leaf(list.compacted());
}

}  // namespace regraft::kdtree
