#pragma once

#include <bit>
#include <cstdint>

#include "regraft/trace/packet_places.h"
#include "regraft/trace/packet_triangle.h"
#include "regraft/trace/single.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// Rays that must still be in a cell for the packet to enter it as one; fewer go on one by one.
inline constexpr int cell_single_below = 4;

/// Primitives that rays of a packet have lately tested, as `Mailbox` for one ray.
class PacketMailbox {
 public:
  PacketMailbox() {
    for (Slot& slot : slots_) slot = {{0xFFFFFFFFu, 0xFFFFFFFFu}, 0};
  }
  /// @return the rays of `mask` that have not tested the primitive; from now on they have.
  REGRAFT_INLINE std::uint64_t post(kdtree::PrimRef ref, std::uint64_t mask) {
    Slot& slot = slots_[(ref.prim ^ ref.object * 7u) % size];
    if (!(slot.ref == ref)) slot = {ref, 0};
    const std::uint64_t fresh = mask & ~slot.tested;
    slot.tested |= mask;
    return fresh;
  }

 private:
  static constexpr std::uint32_t size = 32;
  struct Slot {
    kdtree::PrimRef ref;
    std::uint64_t tested;
  };
  Slot slots_[size];
};

/// Up to 64 rays through the cells of a k-d tree together, each with an interval of its own (Wald,
/// Slusallek, Benthin, Wagner, Interactive Rendering with Coherent Ray Tracing, 2001). Rays whose
/// directions agree in all signs meet the two sides of a plane in the same order; those of every
/// octant make a walk of their own.
///
/// A ray enters the cells that `CellWalk` would have it enter, decided by the same operations: so
/// the tree grows by the same nodes, and what is hit is the same.
template <int R, bool AnyHit>
class CellPacketWalk {
 public:
  CellPacketWalk(const TraceView& view, const RayPacket& rays, TraceCounters& counters)
      : view_(view), rays_(rays), counters_(counters), alive_(rays.active), best_(rays) {}

  void run() {
    counters_.rays += std::uint64_t(std::popcount(alive_));
    alive_ &= valid_lanes(rays_);
    if (alive_ == 0) return;
    Cell all;
    all.node = &view_.kdtree->root();
    std::uint64_t inside = cells_.set<R>(view_, rays_, all.near, all.far) & alive_;
    for (std::uint64_t todo = alive_ & cells_.remapped; todo != 0; todo &= todo - 1)
      single(std::countr_zero(todo));
    inside &= ~cells_.remapped;
    met_ |= inside;
    counters_.rays_met += std::uint64_t(std::popcount(met_));
    while (inside != 0) {
      all.mask = inside & cells_.octant_of(std::countr_zero(inside));
      inside &= ~all.mask;
      walk(all);
    }
  }

  std::uint64_t occluded() const { return rays_.active & occluded_; }
  void store(HitPacket& hits) const { best_.store(rays_.active, hits); }

 private:
  using Node = kdtree::Node;
  static constexpr LaneBits full = LaneBits((std::uint64_t(1) << R) - 1);

  /// What rays of `mask` have of a cell.
  struct alignas(64) Cell {
    float near[lanes_all];
    float far[lanes_all];
    Node* node;
    std::uint64_t mask;
  };

  void walk(const Cell& all) {
    places_.begin(all.mask);
    stack_[0] = all;
    for (int top = 0; top >= 0; --top) {
      Cell& cell = stack_[top];
      cell.mask = reached(cell);
      if (cell.mask != 0) top = descend(top);
    }
  }

  /// The rays that have nothing nearer than the cell.
  REGRAFT_INLINE std::uint64_t reached(const Cell& cell) const {
    std::uint64_t mask = cell.mask & alive_;
    for (int base = 0; base < lanes_all; base += R) {
      if ((mask >> base & full) == 0) continue;
      const LaneBits beyond = Float<R>::load(best_.t + base) < Float<R>::load(cell.near + base);
      mask &= ~(std::uint64_t(beyond) << base);
    }
    return mask;
  }

  /// Down to the first leaf of the cell on top; what comes after is left on the stack below.
  /// @return where on the stack that leaf is.
  REGRAFT_INLINE int descend(int top) {
    while (std::popcount(stack_[top].mask) >= cell_single_below) {
      Node& node = *stack_[top].node;
      const std::uint32_t state = node.state.load(std::memory_order_acquire);
      if (Node::is_inner(state)) {
        ++counters_.nodes_visited;
        counters_.node_entries += std::uint64_t(std::popcount(stack_[top].mask));
        if (enter_sides(node, int(state), stack_[top], stack_[top + 1])) ++top;
      } else if (Node::is_built(state)) {
        test_leaf(node.prims, Node::prim_count(state), stack_[top].mask);
        return top;
      } else {
        view_.kdtree->expand(node);
      }
    }
    for (std::uint64_t todo = stack_[top].mask; todo != 0; todo &= todo - 1)
      single_from(stack_[top], std::countr_zero(todo));
    return top;
  }

  /// `cell` becomes the far side of its node, `next` the near side.
  /// @return false if no ray enters the near side.
  REGRAFT_INLINE bool enter_sides(const Node& node, int axis, Cell& cell, Cell& next) {
    const Float<R> plane(node.split);
    std::uint64_t first = 0, second = 0;
    for (int base = 0; base < lanes_all; base += R) {
      if ((cell.mask >> base & full) == 0) continue;
      const Float<R> inverse = Float<R>::load(cells_.inverse[axis] + base);
      const Float<R> near = Float<R>::load(cell.near + base);
      const Float<R> far = Float<R>::load(cell.far + base);
      const Float<R> begin = (plane - Float<R>::load(cells_.near_origin[axis] + base)) * inverse;
      const Float<R> end = (plane - Float<R>::load(cells_.far_origin[axis] + base)) * inverse;
      // Not a number (a ray in the plane): both sides.
      const LaneBits only_second = end < near;
      const LaneBits only_first = ~only_second & (far < begin);
      first |= std::uint64_t(~only_second & full) << base;
      second |= std::uint64_t(~only_first & full) << base;
      near.store(next.near + base);
      min(end, far).store(next.far + base);
      max(begin, near).store(cell.near + base);
    }
    const bool negative = (cells_.negatives[axis] & cell.mask) != 0;
    next.node = node.children + (negative ? 1 : 0);
    next.mask = first & cell.mask;
    cell.node = node.children + (negative ? 0 : 1);
    cell.mask &= second;
    return next.mask != 0;
  }

  void test_leaf(const kdtree::PrimRef* refs, std::uint32_t count, std::uint64_t mask) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint64_t fresh = mailbox_.post(refs[i], mask & alive_);
      if (fresh == 0) continue;
      Place& place = places_.at<R>(rays_, cells_.top, view_.instances, refs[i].object);
      test_together(place, refs[i], fresh & place.together);
      for (std::uint64_t todo = fresh & place.apart; todo != 0; todo &= todo - 1)
        test_single(place, refs[i], std::countr_zero(todo));
    }
  }

  REGRAFT_INLINE void test_together(Place& place, kdtree::PrimRef ref, std::uint64_t mask) {
    if (mask == 0) return;
    counters_.triangle_tests += std::uint64_t(std::popcount(mask));
    const InstanceView& instance = view_.instances[ref.object];
    const PacketTriangle triangle(instance.mesh, ref.prim);
    for (int kz = 0; kz < 3; ++kz) {
      const std::uint64_t some = mask & place.local.kz_is[kz];
      if (some == 0) continue;
      place.turn_to(kz);
      const std::uint64_t hit = triangle.test<R, AnyHit>(rays_, place.local, instance, some, best_);
      if (AnyHit) occlude(hit);
    }
  }

  void test_single(const Place& place, kdtree::PrimRef ref, int i) {
    const InstanceView& instance = view_.instances[ref.object];
    LocalRay ray;
    if ((place.remapped >> i & 1u) == 0) {
      ray = extract(place.local, rays_, i);
    } else {
      SlabRay top;
      extract_slabs(cells_.top, i, top);
      if (!make_local(load_ray(rays_, std::uint32_t(i)), top, instance, ray)) return;
    }
    Nearest n = best_.at(i);
    Work work;
    float limit = local_limit(ray, n.t);
    test_prims<AnyHit>(ray, instance, &ref.prim, 1, limit, n, work);
    finish_single(i, n, work);
  }

  void single(int i) {
    Nearest n = best_.at(i);
    Work work;
    CellWalk<AnyHit>(view_, load_ray(rays_, std::uint32_t(i)), n, work).run();
    finish_single(i, n, work);
  }

  void single_from(const Cell& cell, int i) {
    Nearest n = best_.at(i);
    Work work;
    SlabRay top;
    extract_slabs(cells_.top, i, top);
    CellWalk<AnyHit>(view_, load_ray(rays_, std::uint32_t(i)), top, cells_.cell_ray(rays_, i), n,
                     work)
        .run({cell.node, cell.near[i], cell.far[i]});
    finish_single(i, n, work);
  }

  void finish_single(int i, const Nearest& n, const Work& work) {
    counters_.nodes_visited += work.nodes;
    counters_.node_entries += work.nodes;
    if (work.all() != 0) met_ |= std::uint64_t(1) << i;
    counters_.triangle_tests += work.tests;
    best_.take(i, n);
    if (AnyHit && n.prim_id != 0xFFFFFFFFu) occlude(std::uint64_t(1) << i);
  }

  void occlude(std::uint64_t lanes) {
    occluded_ |= lanes;
    alive_ &= ~lanes;
  }

  const TraceView& view_;
  const RayPacket& rays_;  ///< every lane holds a ray
  TraceCounters& counters_;
  std::uint64_t alive_;
  std::uint64_t occluded_ = 0;
  std::uint64_t met_ = 0;  ///< rays that go through the tree's box
  NearestPacket best_;
  CellRayPacket cells_;
  Places places_;
  PacketMailbox mailbox_;
  Cell stack_[kdtree::deepest + 2];
};

template <int R>
struct CellPackets {
  static void closest_hit(const TraceView& view, const RayPacket& rays, HitPacket& hits,
                          TraceCounters& counters) {
    RayPacket copy;
    CellPacketWalk<R, false> walk(view, filled(rays, copy), counters);
    walk.run();
    walk.store(hits);
  }
  static std::uint64_t any_hit(const TraceView& view, const RayPacket& rays,
                               TraceCounters& counters) {
    RayPacket copy;
    CellPacketWalk<R, true> walk(view, filled(rays, copy), counters);
    walk.run();
    return walk.occluded();
  }
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
