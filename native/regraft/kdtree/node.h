#pragma once

#include <atomic>
#include <cstdint>

namespace regraft::kdtree {

struct Pending;

/// Edges from the root to the deepest leaf of any tree, whatever the scene (numerics rule N9).
inline constexpr std::uint32_t deepest = 60;

/// A primitive in a leaf: number `prim` of object `object`, as the hierarchy calls them.
struct PrimRef {
  std::uint32_t object;
  std::uint32_t prim;
  friend bool operator==(const PrimRef&, const PrimRef&) = default;
};

/// 16 bytes. The children of an inner node are neighbours: lower side first.
///
/// `state` is what threads agree by: Unbuilt → Building → Inner or Leaf. Who swaps Unbuilt for
/// Building builds the node, and only after a release store of the final state may others read what
/// it points to.
struct Node {
  /// The lowest three bits of `state`; 0, 1, 2: an inner node split on that axis.
  enum Kind : std::uint32_t { leaf = 3, unbuilt = 4, building = 5 };
  static constexpr std::uint32_t kind_bits = 3;
  static constexpr std::uint32_t kind_mask = (1u << kind_bits) - 1;

  std::atomic<std::uint32_t> state{unbuilt};
  float split = 0.0f;
  union {
    Node* children = nullptr;
    const PrimRef* prims;  ///< of a leaf, `state >> kind_bits` of them
    Pending* pending;      ///< of an unbuilt node: what it is to be built from
  };

  static std::uint32_t kind(std::uint32_t state) { return state & kind_mask; }
  static bool is_inner(std::uint32_t state) { return kind(state) < leaf; }
  static bool is_built(std::uint32_t state) { return kind(state) <= leaf; }
  static std::uint32_t prim_count(std::uint32_t state) { return state >> kind_bits; }
};

}  // namespace regraft::kdtree
