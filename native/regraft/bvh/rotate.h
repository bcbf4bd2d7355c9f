#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// `child` of `node` and `grandchild`, a child of its sibling, have changed places: each node of
/// the array now holds what the other did. The box of the sibling, `child ^ 1`, is another.
struct Rotation {
  std::uint32_t node;
  std::uint32_t child;
  std::uint32_t grandchild;
  friend bool operator==(const Rotation&, const Rotation&) = default;
};

/// Which part of a tree a pass of rotations looks at.
struct RotationScope {
  /// True: no exchange is tried at this node or below it. Not given: all are.
  std::function<bool(std::uint32_t)> settled;
  /// Largest number of edges from a node to a leaf; asked of settled nodes and their children.
  std::function<std::uint32_t(std::uint32_t)> height;
};

/// One pass of tree rotations from the leaves up (Kopta, Ize, Spjut, Brunvand, Davis, Kensler,
/// Fast, Effective BVH Updates for Animated Scenes, I3D 2012, section 3): at each inner node the
/// exchange of a child with a grandchild under the other child that shrinks that child most is
/// done, if it saves more than 1e-6 of the node's area. The node's own box stays. Boxes must be
/// right before, and are after.
///
/// Deviation: exchanges of two grandchildren are not tried; each is two of those that are, a
/// frame apart. None makes the tree deeper than `max_depth`. The same exchanges for any number of
/// threads.
/// @return what was exchanged, in the order in which it was.
std::vector<Rotation> rotate(Bvh& bvh, const RotationScope& scope, Executor& executor);

}  // namespace regraft::bvh
