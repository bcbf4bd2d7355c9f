#pragma once

#include <span>

#include "regraft/bvh/bvh.h"
#include "regraft/bvh/sah.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// Top-down builder with binned surface area heuristic (Wald, On fast Construction of SAH-based
/// Bounding Volume Hierarchies, RT 2007), all three axes in one pass.
struct BinnedSahBuilder {
  struct Config {
    /// Below the metric's: kernels test four triangles of a leaf at once, and fewer nodes are
    /// less memory and quicker to refit.
    CostModel cost{0.5};
    std::uint32_t max_leaf = 4;
    /// Levels below the root, at most `bvh::max_depth`.
    std::uint32_t max_depth = bvh::max_depth;
    /// Ranges up to this size are built as one task; independent of the number of threads, so
    /// that the tree is too.
    std::uint32_t task_size = 4096;
  };

  /// Builds over the primitives `ids`, primitive i having `boxes[i]`, finite and not empty.
  /// Both are read only. Ties fall to the lower axis and bin; equal centroids are split in the
  /// middle by id. O(n log n).
  static Bvh build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
                   const Config& config, Executor& executor);
};

}  // namespace regraft::bvh
