#include "regraft/kdtree/sah_scan.h"

#include <bit>

#include "regraft/kdtree/sah_count.h"

namespace regraft::kdtree {
namespace {

/// Few entries do not pay for many bins.
constexpr std::size_t few_entries = 1024;
constexpr int few_bins = 16;

/// The cheapest sample plane of every level, see PlaneSample.
class BestSamples {
 public:
  void offer(const CostedSample& sample, int axis, double cost) {
    Place& best = best_[std::size_t(sample.plane.level)];
    if (cost < best.cost) best = {cost, axis, sample.plane.position};
  }
  struct Place {
    double cost = std::numeric_limits<double>::infinity();
    int axis = -1;
    double position = 0.0;
  };
  /// Calls `use` with the best of the samples up to each level: what fewer samples find, more
  /// find too.
  template <class Use>
  void for_each_level(const Use& use) const {
    Place best;
    for (const Place& place : best_)
      if (place.cost < best.cost) use(best = place);
  }
  Place best() const {
    Place last;
    for_each_level([&last](const Place& place) { last = place; });
    return last;
  }

 private:
  std::array<Place, 8> best_;
};

/// The bounds of entries next to a place, strictly inside the voxel.
struct Neighbours {
  float below = -std::numeric_limits<float>::infinity();
  float above = std::numeric_limits<float>::infinity();
};

Neighbours neighbours(std::span<const SplitEntry> entries, const Aabb& voxel, int axis,
                      double position) {
  Neighbours found;
  for (const SplitEntry& entry : entries)
    for (const float x : {entry.box.lo[axis], entry.box.hi[axis]}) {
      const bool counts = entry.weight > 0.0 && x > voxel.lo[axis] && x < voxel.hi[axis];
      const float below = counts && x < position ? x : found.below;
      const float above = counts && !(x < position) ? x : found.above;
      found.below = std::max(found.below, below);
      found.above = std::min(found.above, above);
    }
  return found;
}

/// The weights beside two planes.
std::array<Sides, 2> count_sides(std::span<const SplitEntry> entries, int axis,
                                 const Neighbours& planes) {
  std::array<Sides, 2> sides;
  const std::array<float, 2> position{planes.below, planes.above};
  for (const SplitEntry& entry : entries) {
    const float lo = entry.box.lo[axis];
    const float hi = entry.box.hi[axis];
    const double weight = entry.weight > 0.0 ? entry.weight : 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      sides[i].left += lo < position[i] ? weight : 0.0;
      sides[i].right += hi > position[i] ? weight : 0.0;
      sides[i].flat += lo == position[i] && hi == position[i] ? weight : 0.0;
    }
  }
  return sides;
}

/// Offers the planes through the bounds of entries on both sides of a sample.
void offer_neighbours(Split& best, const SplitProblem& problem, std::span<const SplitEntry> entries,
                      const BestSamples::Place& sample) {
  if (sample.axis < 0) return;
  const int axis = sample.axis;
  const Neighbours found = neighbours(entries, problem.probability.voxel(), axis, sample.position);
  const std::array<Sides, 2> sides = count_sides(entries, axis, found);
  for (const bool above : {false, true}) {
    const float x = above ? found.above : found.below;
    if (!std::isfinite(x)) continue;
    const ChildProbability::Pair p = problem.probability.at(axis, x);
    offer(best, axis, x, plane_cost(problem.cost, p, sides[above]), p.left < p.right);
    ++best.samples;
  }
}

/// Calls `use(segment)` for neighbouring samples with bounds of entries in between.
template <class Use>
void for_each_segment(const SplitProblem& problem, int axis, std::span<const PlaneSample> samples,
                      BestSamples& cheapest, const Use& use) {
  CostedSample from(problem, axis, samples.front());
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const CostedSample to(problem, axis, samples[i]);
    if (to.plane.level > 0) cheapest.offer(to, axis, to.cost(problem));
    if (!from.nothing_until(to))
      use(ScanSegment{segment_bound(problem, from, to), from.plane, to.plane, axis, int(i), 0, 0});
    from = to;
  }
}

bool flat(const Aabb& voxel, int axis) {
  return !(voxel.lo[axis] < voxel.hi[axis]);
}

}  // namespace

Split SahScan::find(std::span<const SplitEntry> entries, const ChildProbability& probability) {
  const bool few = entries.size() <= config_.exact_below && countable(entries);
  if (!few && (entries.size() <= config_.exact_below || !EventBins::usable(probability.voxel())))
    return sweep_.find(entries, probability);
  const EntrySummary summary = summarise(entries);
  const Split cut = empty_cut(summary, probability, cost_);
  if (cut.found()) return cut;
  const Task task{entries, {cost_, probability}, cost_.intersect * summary.weight};
  Split best = few                              ? count_split(entries, probability, cost_)
               : std::isfinite(config_.epsilon) ? refined(task)
                                                : two_passes(task);
  if (!(best.cost < task.leaf)) best.axis = -1;
  return best;
}

Split SahScan::two_passes(const Task& task) const {
  const Aabb& voxel = task.problem.probability.voxel();
  const UniformSamples uniform(task.entries, voxel, EventBins::max_count);
  const int level = std::bit_width(unsigned(config_.samples));
  const QuantileSamples quantiles(task.entries, uniform, level);
  Split best;
  BestSamples cheapest;
  double bound = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (flat(voxel, axis)) continue;
    const AxisSamples samples = quantiles.samples(axis);
    for_each_segment(task.problem, axis, samples.all(), cheapest,
                     [&bound](const ScanSegment& s) { bound = std::min(bound, s.bound); });
    best.samples += std::uint32_t(samples.all().size()) - 2;
  }
  cheapest.for_each_level([&](const BestSamples::Place& sample) {
    offer_neighbours(best, task.problem, task.entries, sample);
  });
  best.lower_bound = std::min(bound, best.cost);
  return best;
}

Split SahScan::refined(const Task& task) {
  const Aabb& voxel = task.problem.probability.voxel();
  const int bins = task.entries.size() < few_entries ? few_bins : EventBins::max_count;
  const UniformSamples uniform(task.entries, voxel, bins);
  Split best;
  BestSamples cheapest;
  refinement_.clear();
  for (int axis = 0; axis < 3; ++axis) {
    if (flat(voxel, axis)) continue;
    for_each_segment(task.problem, axis, uniform.samples(axis).all(), cheapest,
                     [this](const ScanSegment& s) { refinement_.add(s); });
    best.samples += std::uint32_t(bins) - 1;
  }
  offer_neighbours(best, task.problem, task.entries, cheapest.best());
  refinement_.run(best, task.problem, {config_.epsilon, task.leaf}, task.entries, uniform.bins());
  return best;
}

}  // namespace regraft::kdtree
