#pragma once

#include <cstdint>

#include "regraft/core/aabb.h"

namespace regraft::bvh {

/// 32 bytes. Children of an inner node are neighbours: `first` and `first + 1`, one cache line.
/// Not initialized unless asked for, `Node{}`: room for a tree is made before its parts are written
/// to it by all threads.
struct Node {
  Vec3 lo;
  std::uint32_t first;  ///< inner: left child; leaf: first index into `Bvh::prim_ids`
  Vec3 hi;
  std::uint32_t count;  ///< primitives of a leaf; 0: inner node

  bool leaf() const { return count != 0; }
  Aabb bounds() const { return {lo, hi}; }
  void set_bounds(const Aabb& b) {
    lo = b.lo;
    hi = b.hi;
  }
  friend bool operator==(const Node&, const Node&) = default;
};
static_assert(sizeof(Node) == 32);

}  // namespace regraft::bvh
