#pragma once

#include <cstdint>

#include "regraft/simd/dispatch.h"
#include "regraft/trace/closest_point.h"
#include "regraft/trace/hit.h"

namespace regraft::trace {

struct TraceView;
struct Kernels;

/// Queries against an up-to-date accelerator. Cheap to copy; const and thread-safe; no
/// allocation, no exception. Lives no longer than the accelerator stays unchanged.
class Tracer {
 public:
  Tracer(const TraceView& view, simd::Isa isa);

  /// Nearest hit of every active ray. Rays of a packet should be neighbours: they are traced
  /// together for as long as that pays.
  void closest_hit(const RayPacket& rays, HitPacket& hits, TraceCounters& counters) const;
  /// Bit i is set if active ray i hits anything in [t_near, t_far].
  std::uint64_t any_hit(const RayPacket& rays, TraceCounters& counters) const;

  /// The same one ray at a time, for rays that go everywhere. With `cost` not null, cost[i]
  /// receives nodes visited plus triangles tested by ray i.
  void closest_hit_single(const RayPacket& rays, HitPacket& hits, TraceCounters& counters,
                          std::uint32_t* cost = nullptr) const;
  std::uint64_t any_hit_single(const RayPacket& rays, TraceCounters& counters) const;

  /// Nearest hits found by testing every triangle: the oracle that every tree must equal bit for
  /// bit. O(triangles) a ray.
  void brute_force(const RayPacket& rays, HitPacket& hits, TraceCounters& counters) const;

  /// See trace/closest_point.h.
  PointHit closest_point(const Vec3d& p, double max_distance) const;

 private:
  const TraceView* view_;
  const Kernels* kernels_;
};

}  // namespace regraft::trace
