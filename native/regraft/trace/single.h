#pragma once

#include <bit>
#include <cstdint>

#include "regraft/trace/traverse_bvh.h"
#include "regraft/trace/traverse_kdtree.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

REGRAFT_INLINE WorldRay load_ray(const RayPacket& rays, std::uint32_t i) {
  WorldRay ray;
  for (int k = 0; k < 3; ++k) {
    ray.origin[k] = rays.origin[k][i];
    ray.direction[k] = rays.direction[k][i];
  }
  ray.t_near = rays.t_near[i];
  ray.t_far = rays.t_far[i];
  return ray;
}

REGRAFT_INLINE void store_hit(HitPacket& hits, std::uint32_t i, const Nearest& nearest) {
  const bool miss = nearest.prim_id == 0xFFFFFFFFu;
  hits.t[i] = miss ? infinity : nearest.t;
  hits.u[i] = nearest.u;
  hits.v[i] = nearest.v;
  hits.instance_id[i] = nearest.instance_id;
  hits.prim_id[i] = nearest.prim_id;
}

REGRAFT_INLINE void count(TraceCounters& counters, const Work& work) {
  ++counters.rays;
  counters.nodes_visited += work.nodes;
  counters.node_entries += work.nodes;
  counters.rays_met += work.all() != 0;
  counters.triangle_tests += work.tests;
}

/// Rays through the k-d tree, one after the other.
struct CellRays {
  template <bool AnyHit>
  static Nearest trace(const TraceView& view, const WorldRay& ray, Work& work) {
    Nearest nearest{ray.t_far, 0xFFFFFFFFu, 0xFFFFFFFFu, 0.0f, 0.0f};
    if (valid(ray)) CellWalk<AnyHit>(view, ray, nearest, work).run();
    return nearest;
  }

  /// `cost` may be null.
  static void closest_hit(const TraceView& view, const RayPacket& rays, HitPacket& hits,
                          TraceCounters& counters, std::uint32_t* cost) {
    for (std::uint64_t todo = rays.active; todo != 0; todo &= todo - 1) {
      const auto i = std::uint32_t(std::countr_zero(todo));
      Work work;
      store_hit(hits, i, trace<false>(view, load_ray(rays, i), work));
      if (cost != nullptr) cost[i] = work.nodes + work.tests;
      count(counters, work);
    }
  }

  static std::uint64_t any_hit(const TraceView& view, const RayPacket& rays,
                               TraceCounters& counters) {
    std::uint64_t occluded = 0;
    for (std::uint64_t todo = rays.active; todo != 0; todo &= todo - 1) {
      const auto i = std::uint32_t(std::countr_zero(todo));
      Work work;
      const Nearest nearest = trace<true>(view, load_ray(rays, i), work);
      occluded |= std::uint64_t(nearest.prim_id != 0xFFFFFFFFu) << i;
      count(counters, work);
    }
    return occluded;
  }
};

/// Every ray against every triangle, without any tree.
struct BruteForce {
  static void test_all(const LocalRay& ray, const InstanceView& instance, Nearest& nearest,
                       Work& work) {
    const MeshView& mesh = instance.mesh;
    float limit = local_limit(ray, nearest.t);
    if (mesh.prim_ids != nullptr) {
      test_prims<false>(ray, instance, mesh.prim_ids, int(mesh.prim_count), limit, nearest, work);
      return;
    }
    std::uint32_t prims[64];
    for (std::uint32_t first = 0; first < mesh.prim_count; first += 64) {
      const std::uint32_t left = mesh.prim_count - first;
      const std::uint32_t count = left < 64 ? left : 64;
      for (std::uint32_t i = 0; i < count; ++i) prims[i] = first + i;
      test_prims<false>(ray, instance, prims, int(count), limit, nearest, work);
    }
  }

  static void closest_hit(const TraceView& view, const RayPacket& rays, HitPacket& hits,
                          TraceCounters& counters) {
    for (std::uint64_t todo = rays.active; todo != 0; todo &= todo - 1) {
      const auto i = std::uint32_t(std::countr_zero(todo));
      const WorldRay ray = load_ray(rays, i);
      const SlabRay top = make_top(view, ray);
      Work work;
      Nearest nearest{ray.t_far, 0xFFFFFFFFu, 0xFFFFFFFFu, 0.0f, 0.0f};
      for (std::uint32_t n = 0; n < view.instance_count && valid(ray); ++n) {
        const InstanceView& instance = view.instances[n];
        LocalRay local;
        if (!make_local(ray, top, instance, local)) continue;
        come_near(instance);
        test_all(local, instance, nearest, work);
      }
      store_hit(hits, i, nearest);
      count(counters, work);
    }
  }
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
