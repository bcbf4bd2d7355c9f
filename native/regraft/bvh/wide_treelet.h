#pragma once

#include <cstdint>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/bvh/wide_bvh.h"

namespace regraft::bvh {

/// The binary nodes that one wide node stands for: `count` slots, and above them the opened ones,
/// one fewer.
template <int W>
struct Treelet {
  int count = 1;
  std::uint32_t slots[W];
  /// First children of the opened nodes, in the order in which they were opened.
  std::uint32_t opened[W - 1];

  explicit Treelet(std::uint32_t root) { slots[0] = root; }

  void open(const Bvh& bvh, int slot) {
    const std::uint32_t first = bvh.nodes[slots[slot]].first;
    opened[count - 1] = first;
    slots[slot] = first;
    slots[count++] = first + 1;
  }

  /// Opens the inner slot of largest area that `may_open`, until none is left or all are full.
  template <typename F>
  void open_largest(const Bvh& bvh, const F& may_open) {
    while (count < W) {
      int largest = -1;
      double largest_area = -1.0;
      for (int i = 0; i < count; ++i) {
        const Node& node = bvh.nodes[slots[i]];
        const double area = node.leaf() || !may_open(slots[i]) ? -1.0 : half_area(node.bounds());
        if (area > largest_area) {
          largest_area = area;
          largest = i;
        }
      }
      if (largest < 0) return;
      open(bvh, largest);
    }
  }
};

template <int W>
void set_box(WideNode<W>& node, int slot, const Node& box) {
  for (int k = 0; k < 3; ++k) {
    node.bounds[k][slot] = box.lo[k];
    node.bounds[3 + k][slot] = box.hi[k];
  }
}

/// Boxes, sources and leaves of a treelet; the children of inner slots are left open.
template <int W>
void fill_slots(const Bvh& bvh, const Treelet<W>& treelet, WideNode<W>& node) {
  Node nothing;
  nothing.set_bounds(Aabb{});
  for (int i = 0; i < W; ++i) {
    const bool used = i < treelet.count;
    const Node& source = used ? bvh.nodes[treelet.slots[i]] : nothing;
    set_box(node, i, source);
    node.source[i] = used ? treelet.slots[i] : 0;
    node.child[i] =
        used && source.leaf() ? WideChild::leaf(source.first, source.count) : WideChild::none;
  }
}

/// The wide nodes below one binary node, numbered from 0, its own, on.
template <int W>
struct WidePart {
  AlignedVector<WideNode<W>> nodes;
  /// `Treelet::opened` of all nodes in order: one fewer a node than it has slots.
  std::vector<std::uint32_t> opened;
  /// Binary nodes whose own wide node is still to be made, and where its number is to go.
  struct Open {
    std::uint32_t wide;
    std::uint32_t slot;
    std::uint32_t binary;
  };
  std::vector<Open> open;

  /// Collapses the binary tree below `root` until nothing, or more than `limit` nodes, are open.
  void derive(const Bvh& bvh, std::uint32_t root, std::size_t limit) {
    make_node(bvh, root);
    std::size_t next = 0;
    for (; next < open.size() && open.size() - next < limit; ++next) {
      const Open item = open[next];
      nodes[item.wide].child[item.slot] = std::uint32_t(nodes.size());
      make_node(bvh, item.binary);
    }
    open.erase(open.begin(), open.begin() + std::ptrdiff_t(next));
  }

 private:
  void make_node(const Bvh& bvh, std::uint32_t root) {
    Treelet<W> treelet(root);
    treelet.open_largest(bvh, [](std::uint32_t) { return true; });
    const auto index = std::uint32_t(nodes.size());
    fill_slots(bvh, treelet, nodes.emplace_back());
    opened.insert(opened.end(), treelet.opened, treelet.opened + treelet.count - 1);
    for (int i = 0; i < treelet.count; ++i)
      if (!bvh.nodes[treelet.slots[i]].leaf())
        open.push_back({index, std::uint32_t(i), treelet.slots[i]});
  }
};

}  // namespace regraft::bvh
