#pragma once

#include <span>
#include <vector>

#include "regraft/kdtree/plane_cost.h"

namespace regraft::kdtree {

/// The exact split: every lo and hi of every entry is a candidate, sorted, O(n log n). Wald and
/// Havran, On building fast kd-trees, 2006, section 4.2. Ties: lowest axis, lowest position.
/// Keeps its working memory: one object per thread.
class SahSweep {
 public:
  explicit SahSweep(const SplitCost& cost = {}) : cost_(cost) {}
  Split find(std::span<const SplitEntry> entries, const ChildProbability& probability);

 private:
  /// In the order in which a sweep meets them at one position.
  enum class Kind : std::uint32_t { end, flat, start };
  struct Event {
    float position;
    Kind kind;
    double weight;
  };
  /// Fills `events_` with what lies strictly inside the voxel; returns what surrounds it.
  Sides collect(std::span<const SplitEntry> entries, int axis, const Aabb& voxel);
  void sweep(Split& best, int axis, Sides around, const ChildProbability& probability);

  SplitCost cost_;
  std::vector<Event> events_;
};

}  // namespace regraft::kdtree
