#pragma once

// Rays of the kinds that a picture of a room needs, for the table of the interior-origin metrics.

#include <cmath>
#include <ctime>
#include <limits>

#include "kdtree_scenes.h"
#include "regraft/trace/trace_view.h"
#include "regraft/trace/tracer.h"

namespace regraft::bench {

/// Processor time; the programs have one thread.
inline double now() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

struct Ray {
  Vec3d origin, direction;
};

struct RaySet {
  const char* name;
  bool any;  ///< any hit up to t = 1, else the nearest
  std::vector<Ray> rays;
};

struct RayWork {
  trace::TraceCounters counters;
  double seconds = 0.0;
};

/// Traces `rays` in packets of neighbours; `use(i, t, instance, prim)` gets every hit of nearest.
template <class Use>
RayWork trace_rays(const trace::TraceView& view, const RaySet& set, const Use& use) {
  const trace::Tracer tracer(view, simd::best_isa());
  RayWork work;
  trace::RayPacket packet;
  trace::HitPacket hits;
  for (std::size_t first = 0; first < set.rays.size(); first += trace::packet_capacity) {
    packet.count =
        std::uint32_t(std::min<std::size_t>(trace::packet_capacity, set.rays.size() - first));
    packet.active = ~std::uint64_t(0) >> (64 - packet.count);
    for (std::uint32_t i = 0; i < packet.count; ++i) {
      const Ray& ray = set.rays[first + i];
      for (int k = 0; k < 3; ++k) {
        packet.origin[k][i] = ray.origin[k];
        packet.direction[k][i] = ray.direction[k];
      }
      packet.t_near[i] = 1e-4f;
      packet.t_far[i] = set.any ? 0.999f : std::numeric_limits<float>::infinity();
    }
    const double start = now();
    if (set.any)
      tracer.any_hit_single(packet, work.counters);
    else
      tracer.closest_hit_single(packet, hits, work.counters);
    work.seconds += now() - start;
    if (set.any) continue;
    for (std::uint32_t i = 0; i < packet.count; ++i)
      if (hits.prim_id[i] != invalid_id)
        use(first + i, double(hits.t[i]), hits.instance_id[i], hits.prim_id[i]);
  }
  return work;
}

inline RaySet primary_rays(const View& view, int size) {
  RaySet set{"primary", false, {}};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) set.rays.push_back({view.eye, view.direction(x, y, size)});
  return set;
}

inline Vec3d face_normal(const Scene& scene, std::uint32_t instance, std::uint32_t prim) {
  const Instance& placed = scene.instances()[instance];
  const Mesh& mesh = scene.meshes()[placed.mesh];
  const Triangle& corners = mesh.triangles[prim];
  Vec3d p[3];
  for (int k = 0; k < 3; ++k)
    p[k] = Vec3d(placed.object_to_world * glm::dvec4(Vec3d(mesh.vertices[corners[k]]), 1.0));
  return glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
}

/// Rays to a light inside the room, to one outside, and mirrored ones, from what `primary` hits.
inline std::vector<RaySet> room_rays(const Scene& scene, const trace::TraceView& view,
                                     const RaySet& primary, const Vec3d& inside,
                                     const Vec3d& outside) {
  RaySet to_inside{"shadow, light inside", true, {}};
  RaySet to_outside{"shadow, light outside", true, {}};
  RaySet mirrored{"reflection", false, {}};
  trace_rays(view, primary,
             [&](std::size_t i, double t, std::uint32_t instance, std::uint32_t prim) {
               const Ray& ray = primary.rays[i];
               Vec3d normal = face_normal(scene, instance, prim);
               if (glm::dot(normal, ray.direction) > 0.0) normal = -normal;
               const Vec3d at = ray.origin + t * ray.direction + 1e-4 * normal;
               to_inside.rays.push_back({at, inside - at});
               to_outside.rays.push_back({at, outside - at});
               mirrored.rays.push_back({at, glm::reflect(ray.direction, normal)});
             });
  return {primary, std::move(to_inside), std::move(to_outside), std::move(mirrored)};
}

}  // namespace regraft::bench
