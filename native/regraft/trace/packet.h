#pragma once

#include <bit>
#include <cstdint>
#include <utility>

#include "regraft/trace/packet_mixed.h"
#include "regraft/trace/packet_nearest.h"
#include "regraft/trace/packet_triangle.h"
#include "regraft/trace/single.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// Rays a node's subtree must still concern for the packet to enter it as one; fewer go on one by
/// one. Measured: see docs/benchmarks.md.
inline constexpr int single_below = 8;

/// How the rays of a packet go through nodes.
enum class Going { together, apart };

/// 64 rays through wide nodes together (Wald et al. 2001; large packets and interval culling as
/// in Overbeck, Ramamoorthi, Mark, Large Ray Packets for Real-time Whitted Ray Tracing, RT 2008).
///
/// Where all agree on signs, a node is tested once for the whole packet, its surviving slots then
/// ray by ray in registers of R; otherwise all its slots are, as long as enough rays meet in it.
/// What a ray hits is decided by the same operations as in the single-ray path.
template <int W, int R, bool AnyHit>
class PacketTracer {
 public:
  /// `cost`, if not null, receives nodes visited plus triangles tested by each ray; this asks for
  /// `apart`.
  PacketTracer(const TraceView& view, const RayPacket& rays, TraceCounters& counters, Going going,
               std::uint32_t* cost = nullptr)
      : view_(view),
        rays_(rays),
        counters_(counters),
        going_(going),
        cost_(cost),
        alive_(rays.active),
        sampled_(is_sampled(rays)),
        best_(rays) {}

  void run() {
    trace_all();
    counters_.rays += std::uint64_t(std::popcount(rays_.active));
    counters_.rays_met += std::uint64_t(std::popcount(met_));
  }

  std::uint64_t occluded() const { return rays_.active & occluded_; }
  void store(HitPacket& hits) const { best_.store(rays_.active, hits); }

 private:
  struct Entry {
    const WideNode<W>* parent;
    int slot;
    float near;
    std::uint64_t mask;
  };

  static constexpr LaneBits full = LaneBits((std::uint64_t(1) << R) - 1);

  void trace_all() {
    for (std::uint64_t todo = cost_ != nullptr ? alive_ : 0; todo != 0; todo &= todo - 1)
      cost_[std::countr_zero(todo)] = 0;
    if (alive_ == 0 || view_.top_nodes == nullptr) return;
    alive_ &= valid_lanes(rays_);
    const bool agree = set_top();
    if (view_.flat == nullptr && view_.instance_count == 1) {
      // The tree over instances has nothing to decide.
      enter_instance(view_.instances[0], alive_);
    } else if (view_.flat != nullptr || going_ == Going::apart) {
      singles_from_top(0, alive_);
    } else if (agree) {
      set_intervals<R>(top_);
      walk_packet(
          WideTree<W>(view_.top_nodes, view_.entered), top_, alive_,
          [&](std::uint32_t child, std::uint64_t mask) { top_leaf(child, mask); },
          [&](std::uint32_t child, std::uint64_t mask) { singles_from_top(child, mask); });
    } else if (is_oblique(top_)) {
      met_ |= walk_mixed<W, R>(
          WideTree<W>(view_.top_nodes, view_.entered), top_, rays_.t_near, best_.t, alive_,
          single_below, counters_, [&] { return alive_; },
          [&](std::uint32_t child, std::uint64_t mask) { top_leaf(child, mask); },
          [&](std::uint32_t child, std::uint64_t mask) { singles_from_top(child, mask); });
    } else {
      singles_from_top(0, alive_);
    }
  }

  bool set_top() {
    alignas(64) float origin[3][lanes_all], direction[3][lanes_all];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < lanes_all; ++i) {
        origin[k][i] = float(rays_.origin[k][i] - view_.scene_origin[k]);
        direction[k][i] = float(rays_.direction[k][i]);
      }
    start_ = infinity;
    for (int i = 0; i < lanes_all; ++i)
      start_ = rays_.t_near[i] < start_ ? rays_.t_near[i] : start_;
    return set_slab_packet<R>(top_, origin, direction, view_.magnitude);
  }

  /// `root`: where the ray began.
  void finish_single(int i, std::uint32_t root, const Nearest& n, const Work& work) {
    counters_.nodes_visited += work.nodes;
    // One that looked at a tree's root only found nothing in it.
    if (root != 0 || work.all() > 1) {
      counters_.node_entries += work.nodes;
      met_ |= std::uint64_t(1) << i;
    }
    counters_.triangle_tests += work.tests;
    if (cost_ != nullptr) cost_[i] += work.nodes + work.tests;
    best_.take(i, n);
    if (AnyHit && n.prim_id != 0xFFFFFFFFu) occlude(std::uint64_t(1) << i);
  }

  void occlude(std::uint64_t lanes) {
    occluded_ |= lanes;
    alive_ &= ~lanes;
  }

  void singles_from_top(std::uint32_t child, std::uint64_t mask) {
    for (; mask != 0; mask &= mask - 1) {
      const int i = std::countr_zero(mask);
      Nearest n = best_.at(i);
      Work work{0, 0, sampled_};
      const WorldRay ray = load_ray(rays_, std::uint32_t(i));
      trace_top<W, AnyHit>(view_, ray, make_top(view_, ray), child, n, work);
      finish_single(i, child, n, work);
    }
  }

  std::uint64_t enter_slot(const SlabPacket& packet, const WideNode<W>& node, int slot,
                           std::uint64_t mask) const {
    const float lo[3] = {node.bounds[0][slot], node.bounds[1][slot], node.bounds[2][slot]};
    const float hi[3] = {node.bounds[3][slot], node.bounds[4][slot], node.bounds[5][slot]};
    std::uint64_t entered = 0;
    for (int base = 0; base < lanes_all; base += R) {
      if ((mask >> base & full) == 0) continue;
      const LaneBits lanes = test_box<R>(packet, lo, hi, base, Float<R>::load(rays_.t_near + base),
                                         Float<R>::load(best_.t + base));
      entered |= std::uint64_t(lanes) << base;
    }
    return entered & mask;
  }

  template <typename Leaf, typename Few>
  REGRAFT_INLINE void walk_packet(const WideTree<W>& tree, const SlabPacket& packet,
                                  std::uint64_t mask, const Leaf& leaf, const Few& few) {
    Entry stack[stack_size<W>];
    std::uint64_t met = 0;
    Entry* top = push(stack, tree, 0, packet, mask);
    while (top > stack) {
      const Entry entry = *--top;
      const std::uint64_t entered =
          enter_slot(packet, *entry.parent, entry.slot, entry.mask & alive_);
      if (entered == 0) continue;
      met |= entered;
      const std::uint32_t child = entry.parent->child[entry.slot];
      if (WideChild::is_leaf(child)) {
        if (child == WideChild::none) continue;
        leaf(child, entered);
        continue;
      }
      if (std::popcount(entered) < single_below) {
        few(child, entered);
        continue;
      }
      counters_.node_entries += std::uint64_t(std::popcount(entered));
      top = push(top, tree, child, packet, entered);
    }
    counters_.node_entries += std::uint64_t(std::popcount(met));
    met_ |= met;
  }

  /// Adds the slots of a node that the packet may enter, nearest on top; returns the new end.
  Entry* push(Entry* top, const WideTree<W>& tree, std::uint32_t index, const SlabPacket& packet,
              std::uint64_t mask) {
    ++counters_.nodes_visited;
    const WideNode<W>& node = tree.nodes[index];
    Float<W> near;
    LaneBits lanes = test_slots_packet(node, packet, start_, best_.template limit<R>(mask), near);
    alignas(64) float distance[W];
    near.store(distance);
    Entry* const base = top;
    if (lanes != 0) mark(tree.entered, index);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int slot = __builtin_ctz(lanes);
      prefetch(tree.nodes, node.child[slot]);
      Entry* at = top++;
      for (; at > base && at[-1].near < distance[slot]; --at) *at = at[-1];
      *at = {&node, slot, distance[slot], mask};
    }
    return top;
  }

  void top_leaf(std::uint32_t child, std::uint64_t mask) {
    for (std::uint32_t p = 0; p < WideChild::count(child); ++p) {
      const InstanceView& instance = view_.instances[view_.top_prims[WideChild::begin(child) + p]];
      const std::uint64_t inside = mask & alive_;
      if (std::popcount(inside) < single_below)
        instance_singles(instance, inside);
      else
        enter_instance(instance, inside);
    }
  }

  void enter_instance(const InstanceView& instance, std::uint64_t mask) {
    const std::uint64_t remapped = make_local_packet<R>(rays_, top_, instance, mask, local_);
    if (mask == 0) return;
    come_near(instance);
    if (local_.together && going_ == Going::together && std::popcount(mask) >= single_below) {
      instance_packet(instance, mask);
      return;
    }
    const std::uint64_t here = mask & ~remapped;
    if (going_ == Going::together && std::popcount(here) >= single_below && is_oblique(local_))
      instance_mixed(instance, here);
    else
      singles_in_mesh(instance, 0, here);
    instance_singles(instance, remapped);
  }

  void instance_mixed(const InstanceView& instance, std::uint64_t mask) {
    const std::uint64_t before = counters_.nodes_visited + counters_.triangle_tests;
    const bool sampled = std::exchange(sampled_, false);
    extracted_ = 0;
    met_ |= walk_mixed<W, R>(
        WideTree<W>(instance.mesh.nodes, instance.mesh.entered), local_, rays_.t_near, best_.t,
        mask, single_below, counters_, [&] { return alive_; },
        [&](std::uint32_t child, std::uint64_t inside) { mixed_leaf(instance, child, inside); },
        [&](std::uint32_t child, std::uint64_t inside) {
          for (; inside != 0; inside &= inside - 1) {
            const int i = std::countr_zero(inside);
            const LocalRay ray = local_ray(i);  // a copy, which stays in registers
            single_in_mesh(ray, instance, child, i);
          }
        });
    sampled_ = sampled;
    if (sampled) tell(instance.mesh, counters_.nodes_visited + counters_.triangle_tests - before);
  }

  /// Ray i of `local_` by itself.
  const LocalRay& local_ray(int i) {
    const std::uint64_t bit = std::uint64_t(1) << i;
    if ((extracted_ & bit) == 0) singles_[i] = extract(local_, rays_, i);
    extracted_ |= bit;
    return singles_[i];
  }

  void singles_in_mesh(const InstanceView& instance, std::uint32_t root, std::uint64_t mask) {
    for (; mask != 0; mask &= mask - 1) {
      const int i = std::countr_zero(mask);
      single_in_mesh(extract(local_, rays_, i), instance, root, i);
    }
  }

  /// Four triangles at a time, fetched once, against one ray after the other.
  void mixed_leaf(const InstanceView& instance, std::uint32_t child, std::uint64_t mask) {
    const MeshView& mesh = instance.mesh;
    const std::uint32_t* prims = mesh.prim_ids + WideChild::begin(child);
    const int count = int(WideChild::count(child));
    for (int first = 0; first < count; first += 4) {
      const int n = count - first < 4 ? count - first : 4;
      const Corners4 corners = gather_corners(mesh, prims + first, n);
      mask &= alive_;
      counters_.triangle_tests += std::uint64_t(std::popcount(mask) * n);
      for (std::uint64_t todo = mask; todo != 0; todo &= todo - 1) {
        const int i = std::countr_zero(todo);
        const LocalRay& ray = local_ray(i);
        const auto accept = [&](int lane, float t, float u, float v) {
          const std::uint32_t prim = prims[first + lane];
          if (!best_.at(i).beaten_by(t, instance.instance_id, prim)) return;
          best_.take(i, {t, instance.instance_id, prim, u, v});
          if (AnyHit) occlude(std::uint64_t(1) << i);
        };
        if (ray.kz == 0)
          test_triangles<0>(ray, mesh, corners, prims + first, n, best_.t[i], accept);
        else if (ray.kz == 1)
          test_triangles<1>(ray, mesh, corners, prims + first, n, best_.t[i], accept);
        else
          test_triangles<2>(ray, mesh, corners, prims + first, n, best_.t[i], accept);
      }
    }
  }

  void instance_singles(const InstanceView& instance, std::uint64_t mask) {
    for (; mask != 0; mask &= mask - 1) {
      const int i = std::countr_zero(mask);
      SlabRay top;
      extract_slabs(top_, i, top);
      LocalRay ray;
      if (!make_local(load_ray(rays_, std::uint32_t(i)), top, instance, ray)) continue;
      come_near(instance);
      single_in_mesh(ray, instance, 0, i);
    }
  }

  void single_in_mesh(const LocalRay& ray, const InstanceView& instance, std::uint32_t root,
                      int i) {
    Nearest n = best_.at(i);
    Work work{0, 0, sampled_};
    trace_mesh<W, AnyHit>(ray, instance, root, n, work);
    finish_single(i, root, n, work);
  }

  void instance_packet(const InstanceView& instance, std::uint64_t mask) {
    const std::uint64_t before = counters_.nodes_visited + counters_.triangle_tests;
    const bool sampled = std::exchange(sampled_, false);
    walk_packet(
        WideTree<W>(instance.mesh.nodes, instance.mesh.entered), local_, mask,
        [&](std::uint32_t child, std::uint64_t inside) { mesh_leaf(instance, child, inside); },
        [&](std::uint32_t child, std::uint64_t inside) {
          singles_in_mesh(instance, child, inside);
        });
    sampled_ = sampled;
    if (sampled) tell(instance.mesh, counters_.nodes_visited + counters_.triangle_tests - before);
  }

  void mesh_leaf(const InstanceView& instance, std::uint32_t child, std::uint64_t mask) {
    for (std::uint32_t p = 0; p < WideChild::count(child); ++p) {
      const PacketTriangle triangle(instance.mesh,
                                    instance.mesh.prim_ids[WideChild::begin(child) + p]);
      mask &= alive_;
      counters_.triangle_tests += std::uint64_t(std::popcount(mask));
      const std::uint64_t hit = triangle.test<R, AnyHit>(rays_, local_, instance, mask, best_);
      if (AnyHit) occlude(hit);
    }
  }

  const TraceView& view_;
  const RayPacket& rays_;
  TraceCounters& counters_;
  Going going_;
  std::uint32_t* cost_;
  std::uint64_t alive_;
  bool sampled_;
  std::uint64_t occluded_ = 0;
  std::uint64_t met_ = 0;  ///< rays that found something in a root
  float start_ = 0.0f;
  NearestPacket best_;
  SlabPacket top_;
  LocalPacket local_;
  LocalRay singles_[lanes_all];  ///< those of `local_` that go their own way
  std::uint64_t extracted_ = 0;  ///< which of them are there
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
