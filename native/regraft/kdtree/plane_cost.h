#pragma once

#include <algorithm>
#include <span>

#include "regraft/kdtree/child_probability.h"
#include "regraft/kdtree/split.h"

namespace regraft::kdtree {

/// Weights of the entries beside a plane: lo < plane, hi > plane, lo = hi = plane.
struct Sides {
  double left = 0.0;
  double right = 0.0;
  double flat = 0.0;
};

/// Flat entries join the cheaper side.
inline double plane_cost(const SplitCost& cost, const ChildProbability::Pair& p, const Sides& w) {
  return cost.traverse + cost.intersect * (p.left * w.left + p.right * w.right +
                                           std::min(p.left, p.right) * w.flat);
}

/// Keeps the cheapest plane; ties: lowest axis, then lowest position.
inline void offer(Split& best, int axis, float position, double cost, bool flat_left) {
  const bool first = axis < best.axis || (axis == best.axis && position < best.position);
  if (!(cost < best.cost || (cost == best.cost && first))) return;
  best.axis = axis;
  best.position = position;
  best.cost = cost;
  best.flat_left = flat_left;
}

/// What every search needs to know of the entries that count.
struct EntrySummary {
  Aabb bounds;
  double weight = 0.0;
};
EntrySummary summarise(std::span<const SplitEntry> entries);

/// The plane to take before all others because it cuts off empty space, if there is one.
Split empty_cut(const EntrySummary& entries, const ChildProbability& probability,
                const SplitCost& cost);

}  // namespace regraft::kdtree
