#pragma once

#include <span>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/bvh/sah.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// One tree for a whole shot: area in the surface area heuristic is the sum over key frames of a
/// node's area relative to the root's, Σ_j A_j(n)/A_j(root) (Bittner, Meister, T-SAH: Animation
/// Optimized Bounding Volume Hierarchies, Computer Graphics Forum 2015, section 3). Built once,
/// then only refitted.
///
/// Deviation: their trees are improved by insertion from a first frame's; this one is built from
/// the top, with planes tried across every axis of every key frame.
struct KeyFrameBuilder {
  /// More key frames would be more time and memory for the same tree.
  static constexpr std::size_t max_frames = 8;
  struct Config {
    CostModel cost{0.5};
    std::uint32_t max_leaf = 4;
    /// Ranges up to this size are built as one task; independent of the number of threads.
    std::uint32_t task_size = 4096;
  };

  /// Builds over the primitives `ids`; primitive i has the box `frames[j][i]` in key frame j, empty
  /// where it cannot be hit. The tree has the boxes of the first key frame. 1 to `max_frames`
  /// frames, all read only. O(frames²·n log n). The same tree for any number of threads.
  static Bvh build(std::span<const std::span<const Aabb>> frames,
                   std::span<const std::uint32_t> ids, const Config& config, Executor& executor);
};

}  // namespace regraft::bvh
