#pragma once

#include <span>

#include "regraft/bvh/bvh.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// The fast builder, for frames in which damage is global: primitives in the order of a Morton
/// curve, split where codes differ first (Lauterbach, Garland, Sengupta, Luebke, Manocha, Fast BVH
/// Construction on GPUs, Eurographics 2009, section 3), boxes from the leaves up.
struct MortonBuilder {
  struct Config {
    std::uint32_t max_leaf = 4;
  };

  /// Builds over the primitives `ids`, primitive i having `boxes[i]`, finite and not empty.
  /// Equal codes are halved by position in `ids`, so that no tree is deeper than 30 levels and
  /// those of a balanced one. The same tree for any number of threads. O(n).
  static Bvh build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
                   const Config& config, Executor& executor);
};

}  // namespace regraft::bvh
