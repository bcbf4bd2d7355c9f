#pragma once

// Ray sets that every native benchmark shoots.

#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "bench_scenes.h"
#include "regraft/trace/tracer.h"

namespace regraft::bench {

/// Rays in groups of 64, an 8×8 tile of the image each; within a tile blocks of 4×2 pixels follow
/// one another, so that eight consecutive rays are neighbours for whoever takes eight.
struct RaySet {
  std::string name;
  bool any = false;       ///< only whether something is hit
  bool coherent = false;  ///< neighbours go the same way
  std::vector<float> origin[3], direction[3], t_far;

  std::size_t size() const { return t_far.size(); }
  void add(const Vec3d& o, const Vec3d& d, float far) {
    for (int k = 0; k < 3; ++k) {
      origin[k].push_back(float(o[k]));
      direction[k].push_back(float(d[k]));
    }
    t_far.push_back(far);
  }
};

inline constexpr float no_limit = std::numeric_limits<float>::infinity();

/// Rays from one place through the pixels of a square picture; `direction(x, y)` of a point on it
/// in pixels.
template <typename Direction>
RaySet tiled_rays(int size, const Vec3d& from, const Direction& direction) {
  RaySet set{"primary", false, true, {}, {}, {}};
  for (int tile = 0; tile < size / 8 * (size / 8); ++tile)
    for (int i = 0; i < 64; ++i) {
      const int block = i / 8;
      const int x = tile % (size / 8) * 8 + block % 2 * 4 + i % 4;
      const int y = tile / (size / 8) * 8 + block / 2 * 2 + i % 8 / 4;
      set.add(from, direction(x + 0.5, y + 0.5), no_limit);
    }
  return set;
}

inline RaySet primary_rays(int size) {
  return tiled_rays(size, eye(), [&](double x, double y) { return pixel_direction(x, y, size); });
}

/// Rays [64 p, 64 p + 64) as the tracer takes them.
inline void fill(const RaySet& set, std::size_t p, trace::RayPacket& rays) {
  const std::size_t first = 64 * p;
  rays.count = trace::packet_capacity;
  rays.active = ~std::uint64_t(0);
  for (int k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 64; ++i) {
      rays.origin[k][i] = double(set.origin[k][first + i]);
      rays.direction[k][i] = double(set.direction[k][first + i]);
    }
  for (std::size_t i = 0; i < 64; ++i) {
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = set.t_far[first + i];
  }
}

/// Traces rays [begin, end), which are whole groups, 64 together or one by one.
/// @return how many hit something.
inline std::size_t shoot(const trace::Tracer& tracer, bool packets, const RaySet& set,
                         std::size_t begin, std::size_t end, trace::TraceCounters& counters) {
  trace::RayPacket rays;
  trace::HitPacket hits;
  std::size_t sum = 0;
  for (std::size_t p = begin / 64; p < end / 64; ++p) {
    fill(set, p, rays);
    if (set.any) {
      sum += std::size_t(__builtin_popcountll(packets ? tracer.any_hit(rays, counters)
                                                      : tracer.any_hit_single(rays, counters)));
      continue;
    }
    if (packets)
      tracer.closest_hit(rays, hits, counters);
    else
      tracer.closest_hit_single(rays, hits, counters);
    for (int i = 0; i < 64; ++i) sum += hits.prim_id[i] != invalid_id;
  }
  return sum;
}

/// Shadow rays towards a lamp, and rays of ambient occlusion in random directions of the upper
/// half space, from where `primary` hits `mesh`.
struct SecondaryRays {
  RaySet shadow{"shadow", true, true, {}, {}, {}};
  RaySet occlusion{"occlusion any", true, false, {}, {}, {}};
};
inline SecondaryRays secondary_rays(const RaySet& primary, const Triangles& mesh,
                                    const trace::Tracer& tracer) {
  SecondaryRays sets;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Vec3d lamp(1.5, -1.0, 2.5);
  trace::RayPacket rays;
  trace::HitPacket hits;
  trace::TraceCounters counters;
  for (std::size_t p = 0; p < primary.size() / 64; ++p) {
    fill(primary, p, rays);
    tracer.closest_hit(rays, hits, counters);
    for (int i = 0; i < 64; ++i) {
      if (hits.prim_id[i] == invalid_id) continue;
      const Vec3d d(rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
      const Triangle& t = mesh.triangles[hits.prim_id[i]];
      const Vec3d a(mesh.vertices[t.x]);
      Vec3d normal = glm::cross(Vec3d(mesh.vertices[t.y]) - a, Vec3d(mesh.vertices[t.z]) - a);
      normal = glm::normalize(glm::dot(normal, d) > 0.0 ? -normal : normal);
      const Vec3d point = eye() + double(hits.t[i]) * d + 1e-4 * normal;
      sets.shadow.add(point, lamp - point, 1.0f);
      Vec3d way;
      do way = {uniform(random), uniform(random), uniform(random)};
      while (glm::dot(way, way) > 1.0 || glm::dot(way, way) < 1e-4);
      sets.occlusion.add(point, glm::normalize(normal + glm::normalize(way) * 0.999), no_limit);
    }
  }
  for (RaySet* set : {&sets.shadow, &sets.occlusion})
    while (set->size() % 64 != 0) set->add({0, 0, 100}, {0, 0, 1}, no_limit);
  return sets;
}

}  // namespace regraft::bench
