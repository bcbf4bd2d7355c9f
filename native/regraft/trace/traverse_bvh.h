#pragma once

#include <cstdint>

#include "regraft/bvh/wide_bvh.h"
#include "regraft/trace/hit.h"
#include "regraft/trace/triangle.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

using bvh::WideChild;
using bvh::WideNode;

inline constexpr float infinity = std::numeric_limits<float>::infinity();

/// Enough for the deepest tree: each level leaves at most W − 1 siblings behind.
template <int W>
inline constexpr int stack_size = int(bvh::max_depth) * (W - 1) + W + 1;

struct StackEntry {
  std::uint32_t child;
  float near;
};

/// Work of one ray.
struct Work {
  std::uint32_t nodes = 0;
  std::uint32_t tests = 0;
};

/// Which slots the ray enters in [start, limit]; `near` receives where.
template <int W>
REGRAFT_INLINE LaneBits test_slots(const WideNode<W>& node, const SlabRay& ray, float start,
                                   float limit, Float<W>& near) {
  near = Float<W>(start);
  Float<W> far(limit);
  for (int k = 0; k < 3; ++k)
    widen_axis(Float<W>::load(node.bounds[ray.near_plane[k]]),
               Float<W>::load(node.bounds[ray.far_plane[k]]), Float<W>(ray.near_origin[k]),
               Float<W>(ray.far_origin[k]), Float<W>(ray.inverse[k]), near, far);
  return near <= far;
}

/// Pushes the slots of `lanes`, farthest first, so that the nearest is popped next.
template <int W>
REGRAFT_INLINE int push_slots(const WideNode<W>& node, LaneBits lanes, const Float<W>& near,
                              StackEntry* stack, int top) {
  alignas(64) float distance[W];
  near.store(distance);
  const int base = top;
  for (; lanes != 0; lanes &= lanes - 1) {
    const int i = __builtin_ctz(lanes);
    int at = top++;
    for (; at > base && stack[at - 1].near < distance[i]; --at) stack[at] = stack[at - 1];
    stack[at] = {node.child[i], distance[i]};
  }
  return top;
}

/// Walks a wide tree from `root` on; `leaf(begin, count)` may lower `limit()` and returns true to
/// stop.
template <int W, typename Limit, typename Leaf>
REGRAFT_INLINE void walk(const WideNode<W>* nodes, std::uint32_t root, const SlabRay& ray,
                         float start, Work& work, const Limit& limit, const Leaf& leaf) {
  StackEntry stack[stack_size<W>];
  int top = 1;
  stack[0] = {root, -infinity};
  while (top > 0) {
    const StackEntry entry = stack[--top];
    if (entry.near > limit()) continue;
    if (WideChild::is_leaf(entry.child)) {
      // Planes and origins of 1e38 make an interval NaN, which lets even an unused slot pass.
      if (entry.child == WideChild::none) continue;
      if (leaf(WideChild::begin(entry.child), WideChild::count(entry.child))) return;
      continue;
    }
    ++work.nodes;
    const WideNode<W>& node = nodes[entry.child];
    Float<W> near;
    const LaneBits lanes = test_slots(node, ray, start, limit(), near);
    top = push_slots(node, lanes, near, stack, top);
  }
}

/// Tests primitives of one mesh, four at a time; returns true if `AnyHit` and something was hit.
template <bool AnyHit>
REGRAFT_INLINE bool test_prims(const LocalRay& ray, const InstanceView& instance,
                               const std::uint32_t* prims, int count, Nearest& nearest,
                               Work& work) {
  bool found = false;
  for (int i = 0; i < count && !(AnyHit && found); i += 4) {
    const int n = count - i < 4 ? count - i : 4;
    work.tests += std::uint32_t(n);
    const auto accept = [&](int lane, float t, float u, float v) {
      const std::uint32_t prim = prims[i + lane];
      if (!nearest.beaten_by(t, instance.instance_id, prim)) return;
      nearest = {t, instance.instance_id, prim, u, v};
      found = true;
    };
    const float limit = local_limit(ray, nearest.t);
    if (ray.kz == 0)
      test_triangles<0>(ray, instance.mesh, prims + i, n, limit, accept);
    else if (ray.kz == 1)
      test_triangles<1>(ray, instance.mesh, prims + i, n, limit, accept);
    else
      test_triangles<2>(ray, instance.mesh, prims + i, n, limit, accept);
  }
  return AnyHit && found;
}

/// The mesh's own tree from `root` on, in object space.
template <int W, bool AnyHit>
REGRAFT_INLINE bool trace_mesh(const LocalRay& ray, const InstanceView& instance,
                               std::uint32_t root, Nearest& nearest, Work& work) {
  const auto* nodes = static_cast<const WideNode<W>*>(instance.mesh.nodes);
  bool found = false;
  walk<W>(
      nodes, root, ray, local_start(ray), work, [&] { return local_limit(ray, nearest.t); },
      [&](std::uint32_t begin, std::uint32_t count) {
        return found = test_prims<AnyHit>(ray, instance, instance.mesh.prim_ids + begin, int(count),
                                          nearest, work);
      });
  return found;
}

REGRAFT_INLINE SlabRay make_top(const TraceView& view, const WorldRay& world) {
  float origin[3], direction[3];
  for (int k = 0; k < 3; ++k) {
    origin[k] = float(world.origin[k] - view.scene_origin[k]);
    direction[k] = float(world.direction[k]);
  }
  SlabRay top;
  set_slabs(top, origin, direction, view.magnitude);
  return top;
}

/// Not NaN, within the range of floats, and going somewhere.
REGRAFT_INLINE bool valid(const WorldRay& ray) {
  double length = 0.0;
  double reach = 0.0;
  for (int k = 0; k < 3; ++k) {
    length += std::fabs(ray.direction[k]);
    reach += std::fabs(ray.origin[k]);
  }
  return length > 0.0 && length < 0x1p127 && reach < 0x1p120 && ray.t_near <= ray.t_far;
}

/// Flat layout: a leaf's primitives may be of several instances; runs of one share a local ray.
template <bool AnyHit>
REGRAFT_INLINE bool test_flat_leaf(const TraceView& view, const WorldRay& world, const SlabRay& top,
                                   std::uint32_t begin, std::uint32_t count,
                                   std::uint32_t& local_of, bool& enters, LocalRay& local,
                                   Nearest& nearest, Work& work) {
  std::uint32_t prims[bvh::max_leaf_size];
  for (std::uint32_t i = 0; i < count;) {
    const std::uint32_t instance = view.flat[view.top_prims[begin + i]].instance;
    int run = 0;
    for (; i < count && view.flat[view.top_prims[begin + i]].instance == instance; ++i)
      prims[run++] = view.flat[view.top_prims[begin + i]].prim_id;
    if (instance != local_of) {
      enters = make_local(world, top, view.instances[instance], local);
      local_of = instance;
    }
    if (enters && test_prims<AnyHit>(local, view.instances[instance], prims, run, nearest, work))
      return true;
  }
  return false;
}

/// One ray against everything, from `root` of the top tree on.
template <int W, bool AnyHit>
REGRAFT_INLINE bool trace_top(const TraceView& view, const WorldRay& world, const SlabRay& top,
                              std::uint32_t root, Nearest& nearest, Work& work) {
  const auto* nodes = static_cast<const WideNode<W>*>(view.top_nodes);
  LocalRay local;
  std::uint32_t local_of = 0xFFFFFFFFu;
  bool enters = false;
  bool found = false;
  walk<W>(
      nodes, root, top, world.t_near, work, [&] { return nearest.t; },
      [&](std::uint32_t begin, std::uint32_t count) {
        if (view.flat != nullptr)
          return found = test_flat_leaf<AnyHit>(view, world, top, begin, count, local_of, enters,
                                                local, nearest, work);
        for (std::uint32_t i = 0; i < count && !found; ++i) {
          const InstanceView& instance = view.instances[view.top_prims[begin + i]];
          if (make_local(world, top, instance, local))
            found = trace_mesh<W, AnyHit>(local, instance, 0, nearest, work);
        }
        return found;
      });
  return found;
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
