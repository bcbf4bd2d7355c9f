#include "regraft/kdtree/plane_cost.h"

namespace regraft::kdtree {

EntrySummary summarise(std::span<const SplitEntry> entries) {
  EntrySummary all;
  for (const SplitEntry& entry : entries)
    if (entry.weight > 0.0) {
      all.bounds.extend(entry.box);
      all.weight += entry.weight;
    }
  return all;
}

Split empty_cut(const EntrySummary& entries, const ChildProbability& probability,
                const SplitCost& cost) {
  const Aabb& voxel = probability.voxel();
  Split best;
  for (int k = 0; k < 3; ++k) {
    const double enough = cost.empty_cut * (double(voxel.hi[k]) - double(voxel.lo[k]));
    const auto consider = [&](float position, double gap, bool below) {
      if (!(gap > 0.0 && gap >= enough && position > voxel.lo[k] && position < voxel.hi[k])) return;
      const ChildProbability::Pair p = probability.at(k, position);
      const double kept = (below ? p.right : p.left) * entries.weight;
      offer(best, k, position, cost.traverse + cost.intersect * kept, !below);
    };
    consider(entries.bounds.lo[k], double(entries.bounds.lo[k]) - double(voxel.lo[k]), true);
    consider(entries.bounds.hi[k], double(voxel.hi[k]) - double(entries.bounds.hi[k]), false);
  }
  if (!(best.cost < cost.intersect * entries.weight)) return {};
  best.lower_bound = best.cost;
  best.samples = 1;
  return best;
}

}  // namespace regraft::kdtree
