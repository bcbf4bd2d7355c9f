#pragma once

#include <cstdint>
#include <limits>

#include "regraft/core/vec.h"

namespace regraft::trace {

/// Rays handed to a kernel at once: an 8×8 tile.
inline constexpr std::uint32_t packet_capacity = 64;

/// Up to 64 rays, structure of arrays, world frame. Directions need not be unit vectors; `t` is
/// in units of the direction's length. Rays whose bit in `active` is clear are left alone.
struct alignas(64) RayPacket {
  double origin[3][packet_capacity];
  double direction[3][packet_capacity];
  float t_near[packet_capacity];
  float t_far[packet_capacity];
  std::uint32_t count = 0;
  std::uint64_t active = 0;
};

/// Nearest hits of a packet. A miss: t = inf, ids = `invalid_id`. Barycentric u, v are the
/// weights of the triangle's second and third vertex.
struct alignas(64) HitPacket {
  float t[packet_capacity];
  float u[packet_capacity];
  float v[packet_capacity];
  std::uint32_t instance_id[packet_capacity];
  std::uint32_t prim_id[packet_capacity];
};

/// Deterministic work counts, summed over rays.
struct TraceCounters {
  std::uint64_t rays = 0;
  std::uint64_t nodes_visited = 0;  ///< inner nodes entered, once a ray or once a packet
  /// (ray, inner node) pairs entered; a root by rays that find something in it.
  std::uint64_t node_entries = 0;
  std::uint64_t triangle_tests = 0;  ///< (ray, triangle) pairs evaluated
  std::uint64_t rays_met = 0;        ///< rays that found something in the root
  TraceCounters& operator+=(const TraceCounters& o) {
    rays += o.rays;
    nodes_visited += o.nodes_visited;
    node_entries += o.node_entries;
    triangle_tests += o.triangle_tests;
    rays_met += o.rays_met;
    return *this;
  }
};

}  // namespace regraft::trace
