#pragma once

#include <cstddef>
#include <cstdint>

#include "regraft/kdtree/kdtree.h"

namespace regraft::kdtree {

/// Leaves above this are reported.
inline constexpr std::uint32_t large_leaf = 1024;

/// What has been built of a tree so far.
struct Statistics {
  std::uint64_t inner = 0;
  std::uint64_t leaves = 0;
  std::uint64_t unbuilt = 0;
  std::uint64_t references = 0;  ///< primitives in leaves; those in several count as often
  std::uint64_t large_leaves = 0;
  std::uint32_t largest_leaf = 0;
  std::uint32_t depth = 0;
  std::size_t bytes = 0;
  /// Surface area metric (MacDonald, Booth, Heuristics for Ray Tracing using Space Subdivision,
  /// 1990) of what is built: expected cost of a ray that hits the scene's box.
  double sam_cost = 0.0;
  /// Primitives in leaves against those that wait in unbuilt nodes, in [0, 1].
  double built_fraction = 0.0;

  std::uint64_t nodes() const { return inner + leaves; }
  /// q = (C_SAM / (c·n))^(1 / log2 n), c the mean cost of a leaf: the smaller the better, and the
  /// same for a scene of any size (Hunt, Mark, Fussell 2007). NaN unless n > 1.
  double quality(double primitives, const SplitCost& cost) const;
};

/// Walks all nodes that exist; may be called while rays are traced.
Statistics measure(const KdTree& tree);

}  // namespace regraft::kdtree
