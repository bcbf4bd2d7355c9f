#pragma once

#include <cstdint>
#include <vector>

#include "regraft/bvh/node.h"
#include "regraft/core/aligned.h"

namespace regraft::bvh {

/// No tree is deeper: traversal stacks are sized by it (numerics rule N9).
inline constexpr std::uint32_t max_depth = 60;
/// No leaf holds more primitives: the wide layout has four bits for their number.
inline constexpr std::uint32_t max_leaf_size = 16;

/// A binary bounding volume hierarchy over primitives known by index; holds no geometry.
///
/// Node 0 is the root, node 1 is unused so that every pair of children shares a cache line.
/// Builders put children after their parents; restructuring puts them where there is room. No
/// primitives: no nodes.
struct Bvh {
  AlignedVector<Node> nodes;
  std::vector<std::uint32_t> prim_ids;
  /// Largest number of edges from the root to a leaf.
  std::uint32_t depth = 0;
  /// First nodes of pairs that are not in use.
  std::vector<std::uint32_t> free_pairs;

  bool empty() const { return nodes.empty(); }
  Aabb bounds() const { return empty() ? Aabb{} : nodes[0].bounds(); }
  /// Nodes in use, without the padding.
  std::size_t node_count() const {
    return nodes.size() > 1 ? nodes.size() - 1 - 2 * free_pairs.size() : nodes.size();
  }
  std::size_t bytes() const {
    return nodes.capacity() * sizeof(Node) +
           (prim_ids.capacity() + free_pairs.capacity()) * sizeof(std::uint32_t);
  }
  friend bool operator==(const Bvh&, const Bvh&) = default;
};

}  // namespace regraft::bvh
