#pragma once

#include "regraft/bvh/wide_treelet.h"
#include "regraft/simd/gather.h"

namespace regraft::bvh {

/// What an unused slot is a copy of.
inline const Node& empty_node() {
  static const Node node = [] {
    Node empty{};
    empty.set_bounds(Aabb{});
    return empty;
  }();
  return node;
}

/// The boxes of the nodes `of[i]` side by side.
template <int W>
void transpose_boxes(const Node* const (&of)[W], WideNode<W>& node) {
  using simd::REGRAFT_SIMD_NAMESPACE::transpose;
  using Float4 = simd::REGRAFT_SIMD_NAMESPACE::Float<4>;
  for (int i = 0; i < W; i += 4)
    for (int end = 0; end < 2; ++end) {
      // What shares the register with a corner, a number, is dropped with the fourth row.
      Float4 row[4];
      for (int k = 0; k < 4; ++k)
        row[k] = Float4::load(reinterpret_cast<const float*>(of[i + k]) + 4 * end);
      transpose(row);
      for (int k = 0; k < 3; ++k) row[k].store(&node.bounds[3 * end + k][i]);
    }
}

/// Takes over the boxes of the binary nodes behind the slots.
template <int W>
void gather_boxes(const Bvh& bvh, WideNode<W>& node) {
  const Node* of[W];
  for (int i = 0; i < W; ++i)
    of[i] = node.child[i] == WideChild::none ? &empty_node() : &bvh.nodes[node.source[i]];
  transpose_boxes(of, node);
}

/// Boxes, sources and leaves of a treelet; the children of inner slots are left to the caller.
template <int W>
void fill_slots(const Bvh& bvh, const Treelet<W>& treelet, WideNode<W>& node) {
  const Node* of[W];
  for (std::uint32_t i = 0; i < W; ++i) {
    const bool used = i < treelet.count;
    of[i] = used ? &bvh.nodes[treelet.slots[i]] : &empty_node();
    node.source[i] = used ? treelet.slots[i] : 0;
    node.child[i] = of[i]->leaf() ? WideChild::leaf(of[i]->first, of[i]->count) : WideChild::none;
  }
  transpose_boxes(of, node);
}

}  // namespace regraft::bvh
