#include "regraft/kdtree/sah_sweep.h"

#include <algorithm>

namespace regraft::kdtree {

Split SahSweep::find(std::span<const SplitEntry> entries, const ChildProbability& probability) {
  const EntrySummary summary = summarise(entries);
  const Split cut = empty_cut(summary, probability, cost_);
  if (cut.found()) return cut;
  Split best;
  for (int axis = 0; axis < 3; ++axis)
    sweep(best, axis, collect(entries, axis, probability.voxel()), probability);
  best.lower_bound = best.cost;
  if (!(best.cost < cost_.intersect * summary.weight)) best.axis = -1;
  return best;
}

Sides SahSweep::collect(std::span<const SplitEntry> entries, int axis, const Aabb& voxel) {
  const float x0 = voxel.lo[axis];
  const float x1 = voxel.hi[axis];
  Sides around;
  events_.clear();
  for (const SplitEntry& entry : entries) {
    const float lo = entry.box.lo[axis];
    const float hi = entry.box.hi[axis];
    const double weight = entry.weight;
    if (!(weight > 0.0)) continue;
    // Left of every plane inside, from the start; right of every one, to the end.
    if (lo <= x0) around.left += weight;
    if (hi > x0) around.right += weight;
    if (lo == hi && lo > x0 && lo < x1) {
      events_.push_back({lo, Kind::flat, weight});
      continue;
    }
    if (lo > x0 && lo < x1) events_.push_back({lo, Kind::start, weight});
    if (hi > x0 && hi < x1) events_.push_back({hi, Kind::end, weight});
  }
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return a.position < b.position || (a.position == b.position && a.kind < b.kind);
  });
  return around;
}

void SahSweep::sweep(Split& best, int axis, Sides sides, const ChildProbability& probability) {
  for (std::size_t i = 0; i < events_.size();) {
    const float position = events_[i].position;
    std::array<double, 3> met{};
    for (; i < events_.size() && events_[i].position == position; ++i)
      met[std::size_t(events_[i].kind)] += events_[i].weight;
    const double ending = met[std::size_t(Kind::end)];
    sides.flat = met[std::size_t(Kind::flat)];
    sides.right -= ending + sides.flat;
    const ChildProbability::Pair p = probability.at(axis, position);
    offer(best, axis, position, plane_cost(cost_, p, sides), p.left < p.right);
    ++best.samples;
    sides.left += met[std::size_t(Kind::start)] + sides.flat;
  }
}

}  // namespace regraft::kdtree
