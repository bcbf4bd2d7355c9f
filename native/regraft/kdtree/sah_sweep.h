#pragma once

#include <span>
#include <vector>

#include "regraft/kdtree/split_event.h"

namespace regraft::kdtree {

/// The exact split: every lo and hi of every entry is a candidate, sorted, O(n log n). Wald and
/// Havran, On building fast kd-trees, 2006, section 4.2. Ties: lowest axis, lowest position.
/// Keeps its working memory: one object per thread.
class SahSweep {
 public:
  explicit SahSweep(const SplitCost& cost = {}) : cost_(cost) {}
  void set(const SplitCost& cost) { cost_ = cost; }
  Split find(std::span<const SplitEntry> entries, const ChildProbability& probability);

 private:
  /// Fills `events_` with what lies strictly inside the voxel; returns what surrounds it.
  Sides collect(std::span<const SplitEntry> entries, int axis, const Aabb& voxel);

  SplitCost cost_;
  std::vector<SplitEvent> events_;
};

}  // namespace regraft::kdtree
