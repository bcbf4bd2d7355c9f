#include "regraft/kdtree/sah_sweep.h"

namespace regraft::kdtree {

Split SahSweep::find(std::span<const SplitEntry> entries, const ChildProbability& probability) {
  const EntrySummary summary = summarise(entries);
  const Split cut = empty_cut(summary, probability, cost_);
  if (cut.found()) return cut;
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    const Sides around = collect(entries, axis, probability.voxel());
    sweep_events(best, {cost_, probability}, axis, events_, around);
  }
  best.lower_bound = best.cost;
  if (!(best.cost < cost_.intersect * summary.weight)) best.axis = -1;
  return best;
}

Sides SahSweep::collect(std::span<const SplitEntry> entries, int axis, const Aabb& voxel) {
  using Kind = SplitEvent::Kind;
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
    const bool starts = lo > x0 && lo < x1;
    if (starts) events_.push_back({lo, lo == hi ? Kind::flat : Kind::start, weight});
    if (hi > x0 && hi < x1 && lo != hi) events_.push_back({hi, Kind::end, weight});
  }
  return around;
}

}  // namespace regraft::kdtree
