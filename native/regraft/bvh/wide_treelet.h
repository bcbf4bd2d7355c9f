#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/bvh/wide_bvh.h"

namespace regraft::bvh {

/// The binary nodes that one wide node stands for: `count` slots, and above them the opened ones,
/// one fewer.
template <int W>
struct Treelet {
  std::uint32_t count = 1;
  std::uint32_t slots[W];
  /// First children of the opened nodes, in the order in which they were opened.
  std::uint32_t opened[W - 1];

  Treelet() = default;
  explicit Treelet(std::uint32_t root) { slots[0] = root; }

  /// First child of the treelet's root; 0, which is nobody's child, for a single leaf.
  std::uint32_t root_pair() const { return count > 1 ? opened[0] : 0; }

  void open(const Bvh& bvh, std::uint32_t slot) {
    const std::uint32_t first = bvh.nodes[slots[slot]].first;
    opened[count - 1] = first;
    slots[slot] = first;
    slots[count++] = first + 1;
  }

  /// Opens the inner slot of largest area that `may_open`, the first among equals, until none is
  /// left or all are full.
  template <typename F>
  void open_largest(const Bvh& bvh, const F& may_open) {
    // Keys to take the maximum of without branching: the processor foretells none of them.
    std::uint64_t keys[W] = {};
    for (std::uint32_t i = 0; i < count; ++i) keys[i] = key(bvh, i, may_open);
    while (count < W) {
      std::uint64_t largest = keys[0];
      for (int i = 1; i < W; ++i) largest = std::max(largest, keys[i]);
      if (largest == 0) return;
      const auto slot = std::uint32_t(W - 1 - largest % W);
      open(bvh, slot);
      keys[slot] = key(bvh, slot, may_open);
      keys[count - 1] = key(bvh, count - 1, may_open);
    }
  }

 private:
  /// Grows with the area of an inner slot, with the slot's number in its lowest bits; 0: do not
  /// open.
  template <typename F>
  std::uint64_t key(const Bvh& bvh, std::uint32_t slot, const F& may_open) const {
    const Node& node = bvh.nodes[slots[slot]];
    const Vec3d e = Vec3d(node.hi) - Vec3d(node.lo);
    const double area = e.x * (e.y + e.z) + e.y * e.z;
    // Positive doubles are in the order of their bits.
    const std::uint64_t bits = (std::bit_cast<std::uint64_t>(area) | W) / W * W + (W - 1 - slot);
    return node.leaf() || !may_open(slots[slot]) ? 0 : bits;
  }
};

/// The wide nodes below one binary node, before they are written. Siblings have numbers in a row.
template <int W>
struct WidePart {
  struct Item {
    Treelet<W> treelet;
    std::uint32_t first_child = 0;  ///< number of the first inner slot
  };
  std::vector<Item> items;
  /// Numbers and binary nodes of what is still to be opened.
  struct Open {
    std::uint32_t number;
    std::uint32_t binary;
  };
  std::vector<Open> open;

  /// Collapses all of the binary tree below `root`, depth first, as builders lay nodes out.
  void derive(const Bvh& bvh, std::uint32_t root) {
    start(root);
    while (!open.empty()) {
      const Open next = open.back();
      open.pop_back();
      make(bvh, next);
      std::reverse(open.end() - std::ptrdiff_t(added_), open.end());
    }
  }

  /// Collapses the top of the tree, breadth first, until `limit` nodes are open. Their numbers are
  /// the last ones, in the order of `open`.
  void derive_top(const Bvh& bvh, std::size_t limit) {
    start(0);
    std::size_t next = 0;
    for (; next < open.size() && open.size() - next < limit; ++next) make(bvh, open[next]);
    open.erase(open.begin(), open.begin() + std::ptrdiff_t(next));
    items.resize(next);
  }

 private:
  void start(std::uint32_t root) {
    items.resize(1);
    open.push_back({0, root});
  }

  void make(const Bvh& bvh, Open next) {
    // Builders lay nodes out depth first: most of what is to be opened follows.
    for (int line = 1; line < 10; ++line)
      __builtin_prefetch(&bvh.nodes[bvh.nodes[next.binary].first] + 2 * line);
    Treelet<W> treelet(next.binary);
    treelet.open_largest(bvh, [](std::uint32_t) { return true; });
    const auto first_child = std::uint32_t(items.size());
    added_ = 0;
    for (std::uint32_t i = 0; i < treelet.count; ++i)
      if (!bvh.nodes[treelet.slots[i]].leaf())
        open.push_back({first_child + added_++, treelet.slots[i]});
    items[next.number] = {treelet, first_child};
    items.resize(first_child + added_);
  }

  std::uint32_t added_ = 0;
};

}  // namespace regraft::bvh
