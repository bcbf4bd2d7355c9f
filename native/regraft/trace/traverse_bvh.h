#pragma once

#include <atomic>
#include <cstdint>
#include <utility>

#include "regraft/bvh/wide_bvh.h"
#include "regraft/trace/hit.h"
#include "regraft/trace/late_tree.h"
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
  bool sampled = false;  ///< what is done in a mesh is told to the mesh

  std::uint32_t all() const { return nodes + tests; }
};

REGRAFT_INLINE void tell(const MeshView& mesh, std::uint64_t work) {
  if (mesh.work == nullptr) return;
  std::atomic_ref<std::uint64_t>(*mesh.work).fetch_add(work, std::memory_order_relaxed);
}

/// To be called when rays have come to an instance's box, before its mesh's tree is looked at.
REGRAFT_INLINE void come_near(const InstanceView& instance) {
  if (instance.mesh.late != nullptr) [[unlikely]]
    instance.mesh.late->arrive();
}

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

/// Asks for all cache lines of a node that will be visited soon.
template <int W>
REGRAFT_INLINE void prefetch(const WideNode<W>* nodes, std::uint32_t child) {
  if (WideChild::is_leaf(child)) return;
  const char* lines = reinterpret_cast<const char*>(nodes + child);
  for (int i = 0; i < int(sizeof(WideNode<W>)); i += 64) __builtin_prefetch(lines + i);
}

/// Notes that a node was entered. Looks before it writes: a line that nobody writes is shared.
REGRAFT_INLINE void mark(std::uint8_t* entered, std::uint32_t node) {
  const std::atomic_ref<std::uint8_t> flag(entered[node]);
  if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
}

/// A wide tree as rays see it.
template <int W>
struct WideTree {
  const WideNode<W>* nodes;
  std::uint8_t* entered;

  WideTree(const void* tree_nodes, std::uint8_t* tree_entered)
      : nodes(static_cast<const WideNode<W>*>(tree_nodes)), entered(tree_entered) {}
};

/// The nearest of the slots in `lanes`; pushes the others, farthest first.
template <int W>
REGRAFT_INLINE std::uint32_t descend(const WideNode<W>* nodes, const WideNode<W>& node,
                                     LaneBits lanes, const Float<W>& near, StackEntry*& top) {
  const int first = __builtin_ctz(lanes);
  lanes &= lanes - 1;
  if (lanes == 0) return node.child[first];
  alignas(64) float distance[W];
  near.store(distance);
  StackEntry nearest{node.child[first], distance[first]};
  prefetch(nodes, nearest.child);
  StackEntry* const base = top;
  for (; lanes != 0; lanes &= lanes - 1) {
    const int i = __builtin_ctz(lanes);
    StackEntry far{node.child[i], distance[i]};
    prefetch(nodes, far.child);
    if (far.near < nearest.near) std::swap(far, nearest);
    StackEntry* at = top++;
    for (; at > base && at[-1].near < far.near; --at) *at = at[-1];
    *at = far;
  }
  return nearest.child;
}

/// Walks a wide tree from `root` on, nearest slots first. `leaf(begin, count, limit)` may lower
/// `limit`, beyond which nothing counts, and returns true to stop.
template <int W, typename Leaf>
REGRAFT_INLINE void walk(const WideTree<W>& tree, std::uint32_t root, const SlabRay& ray,
                         float start, float limit, Work& work, const Leaf& leaf) {
  StackEntry stack[stack_size<W>];
  StackEntry* top = stack;
  std::uint32_t current = root;
  for (;;) {
    if (!WideChild::is_leaf(current)) {
      ++work.nodes;
      Float<W> near;
      const WideNode<W>& node = tree.nodes[current];
      if (const LaneBits lanes = test_slots(node, ray, start, limit, near); lanes != 0) {
        mark(tree.entered, current);
        current = descend(tree.nodes, node, lanes, near, top);
        continue;
      }
    } else if (current != WideChild::none) {
      // Planes and origins of 1e38 make an interval NaN, which lets even an unused slot pass.
      if (leaf(WideChild::begin(current), WideChild::count(current), limit)) return;
    }
    do {
      if (top == stack) return;
      --top;
    } while (top->near > limit);
    current = top->child;
  }
}

/// Tests primitives of one mesh, four at a time; returns true if `AnyHit` and something was hit.
/// `limit`: `local_limit` of the nearest hit, kept up to date.
template <bool AnyHit>
REGRAFT_INLINE bool test_prims(const LocalRay& ray, const InstanceView& instance,
                               const std::uint32_t* prims, int count, float& limit,
                               Nearest& nearest, Work& work) {
  bool found = false;
  for (int i = 0; i < count && !(AnyHit && found); i += 4) {
    const int n = count - i < 4 ? count - i : 4;
    work.tests += std::uint32_t(n);
    const auto accept = [&](int lane, float t, float u, float v) {
      const std::uint32_t prim = prims[i + lane];
      if (!nearest.beaten_by(t, instance.instance_id, prim)) return;
      nearest = {t, instance.instance_id, prim, u, v};
      limit = local_limit(ray, t);
      found = true;
    };
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
  const WideTree<W> tree(instance.mesh.nodes, instance.mesh.entered);
  const std::uint32_t before = work.all();
  bool found = false;
  walk<W>(tree, root, ray, local_start(ray), local_limit(ray, nearest.t), work,
          [&](std::uint32_t begin, std::uint32_t count, float& limit) {
            return found = test_prims<AnyHit>(ray, instance, instance.mesh.prim_ids + begin,
                                              int(count), limit, nearest, work);
          });
  if (work.sampled) tell(instance.mesh, work.all() - before);
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
    if (!enters) continue;
    float limit = local_limit(local, nearest.t);
    if (test_prims<AnyHit>(local, view.instances[instance], prims, run, limit, nearest, work))
      return true;
  }
  return false;
}

/// One ray against everything, from `root` of the top tree on.
template <int W, bool AnyHit>
REGRAFT_INLINE bool trace_top(const TraceView& view, const WorldRay& world, const SlabRay& top,
                              std::uint32_t root, Nearest& nearest, Work& work) {
  const WideTree<W> tree(view.top_nodes, view.entered);
  LocalRay local;
  std::uint32_t local_of = 0xFFFFFFFFu;
  bool enters = false;
  bool found = false;
  walk<W>(tree, root, top, world.t_near, nearest.t, work,
          [&](std::uint32_t begin, std::uint32_t count, float& limit) {
            if (view.flat != nullptr) {
              found = test_flat_leaf<AnyHit>(view, world, top, begin, count, local_of, enters,
                                             local, nearest, work);
              limit = nearest.t;
              return found;
            }
            for (std::uint32_t i = 0; i < count && !found; ++i) {
              const InstanceView& instance = view.instances[view.top_prims[begin + i]];
              if (!make_local(world, top, instance, local)) continue;
              come_near(instance);
              found = trace_mesh<W, AnyHit>(local, instance, 0, nearest, work);
            }
            limit = nearest.t;
            return found;
          });
  return found;
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
