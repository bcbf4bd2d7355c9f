#pragma once

#include <limits>
#include <span>

#include "regraft/kdtree/sah_sweep.h"
#include "regraft/kdtree/scan_refinement.h"

namespace regraft::kdtree {

struct ScanConfig {
  /// Refine until the cost is proven to be at most 1 + epsilon times the least possible; 0: the
  /// exact split without sorting all. Infinite: two passes, and the proof is what they gave. What
  /// is found lies far below the bound: under 0.3 % above the least from 3,000 entries on.
  double epsilon = 0.3;
  /// Of two passes: planes per axis and pass, one less than a power of two, at most 63.
  int samples = 15;
  /// So few entries are sorted: exact, and hardly dearer.
  std::size_t exact_below = 32;
};

/// A split whose error is bounded, in O(n): Hunt, Mark, Stoll, Fast kd-tree construction with an
/// adaptive error-bounded heuristic, 2006. Of that paper the idea: sample the cost at equal
/// distances, then where N_left − N_right changes. Ours: the certificate (scan_segments.h), the
/// refinement to any epsilon, and that a sample only points at bounds of entries, of which the
/// cheaper neighbour is the plane returned: its cost is exact and it is never worse.
/// Keeps its working memory: one object per thread.
class SahScan {
 public:
  explicit SahScan(const SplitCost& cost = {}, const ScanConfig& config = {})
      : cost_(cost), config_(config), sweep_(cost) {}
  void set(const SplitCost& cost, const ScanConfig& config) {
    cost_ = cost;
    config_ = config;
    sweep_.set(cost);
  }
  Split find(std::span<const SplitEntry> entries, const ChildProbability& probability);

 private:
  struct Task {
    std::span<const SplitEntry> entries;
    SplitProblem problem;
    double leaf;
  };
  Split two_passes(const Task& task) const;
  Split refined(const Task& task);

  SplitCost cost_;
  ScanConfig config_;
  SahSweep sweep_;
  ScanRefinement refinement_;
};

}  // namespace regraft::kdtree
