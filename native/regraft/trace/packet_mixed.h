#pragma once

#include <bit>
#include <cstdint>

#include "regraft/trace/packet_nearest.h"
#include "regraft/trace/packet_rays.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// True if no ray is parallel to any axis' planes.
REGRAFT_INLINE bool is_oblique(const SlabPacket& packet) {
  bool oblique = true;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < lanes_all; ++i) oblique &= std::fabs(packet.inverse[k][i]) < infinity;
  return oblique;
}

/// For each slot of a node the rays of `mask` that enter it in [t_near, t]. The rays need not agree
/// on signs: lower planes are always measured from the larger of a ray's two origins, so the nearer
/// plane is the one whose distance is less, bit for bit what `box_interval` computes. No ray is
/// parallel to any plane.
template <int W, int R>
REGRAFT_INLINE void enter_slots(const WideNode<W>& node, const SlabPacket& packet,
                                const float (&t_near)[lanes_all], const float (&t)[lanes_all],
                                std::uint64_t mask, std::uint64_t (&entered)[W]) {
  constexpr auto full = LaneBits((std::uint64_t(1) << R) - 1);
  for (int slot = 0; slot < W; ++slot) entered[slot] = 0;
  for (int base = 0; base < lanes_all; base += R) {
    if ((mask >> base & full) == 0) continue;
    Float<R> lower[3], upper[3], inverse[3];
    for (int k = 0; k < 3; ++k) {
      const Float<R> near = Float<R>::load(packet.near_origin[k] + base);
      const Float<R> far = Float<R>::load(packet.far_origin[k] + base);
      lower[k] = max(near, far);
      upper[k] = min(near, far);
      inverse[k] = Float<R>::load(packet.inverse[k] + base);
    }
    const Float<R> start = Float<R>::load(t_near + base), end = Float<R>::load(t + base);
    for (int slot = 0; slot < W && node.child[slot] != WideChild::none; ++slot) {
      Float<R> near = start, far = end;
      for (int k = 0; k < 3; ++k) {
        const Float<R> a = (Float<R>(node.bounds[k][slot]) - lower[k]) * inverse[k];
        const Float<R> b = (Float<R>(node.bounds[3 + k][slot]) - upper[k]) * inverse[k];
        near = max(min(a, b), near);
        far = min(max(a, b), far);
      }
      entered[slot] |= std::uint64_t(near <= far) << base;
    }
  }
  for (int slot = 0; slot < W; ++slot) entered[slot] &= mask;
}

/// Rays that go different ways from places close together through a wide tree, as long as enough of
/// them meet in a node (Tsakok, Faster Incoherent Rays: Multi-BVH Ray Stream Tracing, HPG 2009,
/// with SIMD over rays). What a packet cannot be asked at once is asked of each ray.
///
/// `alive()` gives the rays that still want to know; `leaf(child, mask)` tests a leaf;
/// `few(child, mask)` takes over where less than `least` rays enter.
/// @return the rays that found something in the root together.
template <int W, int R, typename Alive, typename Leaf, typename Few>
REGRAFT_INLINE std::uint64_t walk_mixed(const WideTree<W>& tree, const SlabPacket& packet,
                                        const float (&t_near)[lanes_all],
                                        const float (&t)[lanes_all], std::uint64_t mask, int least,
                                        TraceCounters& counters, const Alive& alive,
                                        const Leaf& leaf, const Few& few) {
  struct Entry {
    std::uint32_t child;
    float near;
    std::uint64_t mask;
  };
  Entry stack[stack_size<W>];
  Entry* top = stack;
  *top++ = {0, 0.0f, mask};
  std::uint64_t met = 0;
  while (top > stack) {
    const Entry entry = *--top;
    const std::uint64_t inside = entry.mask & alive();
    if (inside == 0) continue;
    if (std::popcount(inside) < least) {
      few(entry.child, inside);
      continue;
    }
    ++counters.nodes_visited;
    const WideNode<W>& node = tree.nodes[entry.child];
    std::uint64_t entered[W];
    enter_slots<W, R>(node, packet, t_near, t, inside, entered);
    // Nearest first for one of the rays, which stands for all.
    const int one = std::countr_zero(inside);
    SlabRay ray;
    extract_slabs(packet, one, ray);
    Float<W> near;
    test_slots(node, ray, t_near[one], t[one], near);
    alignas(64) float distance[W];
    near.store(distance);
    Entry* const base = top;
    std::uint64_t any = 0;
    for (int slot = 0; slot < W; ++slot) {
      if (entered[slot] == 0) continue;
      any |= entered[slot];
      const std::uint32_t child = node.child[slot];
      if (WideChild::is_leaf(child)) {
        leaf(child, entered[slot]);
        continue;
      }
      prefetch(tree.nodes, child);
      Entry* at = top++;
      for (; at > base && at[-1].near < distance[slot]; --at) *at = at[-1];
      *at = {child, distance[slot], entered[slot]};
    }
    if (any != 0) mark(tree.entered, entry.child);
    if (entry.child == 0) met = any;
    counters.node_entries += std::uint64_t(std::popcount(entry.child == 0 ? any : inside));
  }
  return met;
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
