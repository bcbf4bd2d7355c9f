#pragma once

// Included by each kernels_*.cpp, which is compiled with the flags of its instruction set.

#include "regraft/trace/kernels.h"
#include "regraft/trace/packet.h"
#include "regraft/trace/packet_cells.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// The queries of packets.
template <int W, int R, Going going>
struct Packets {
  static void closest_hit(const TraceView& view, const RayPacket& rays, HitPacket& hits,
                          TraceCounters& counters) {
    closest_hit(view, rays, hits, counters, nullptr);
  }
  static void closest_hit(const TraceView& view, const RayPacket& rays, HitPacket& hits,
                          TraceCounters& counters, std::uint32_t* cost) {
    if (view.kdtree != nullptr) {
      if (going == Going::together) return CellPackets<R>::closest_hit(view, rays, hits, counters);
      return CellRays::closest_hit(view, rays, hits, counters, cost);
    }
    RayPacket copy;
    PacketTracer<W, R, false> tracer(view, filled(rays, copy), counters, going, cost);
    tracer.run();
    tracer.store(hits);
  }
  static std::uint64_t any_hit(const TraceView& view, const RayPacket& rays,
                               TraceCounters& counters) {
    if (view.kdtree != nullptr)
      return going == Going::together ? CellPackets<R>::any_hit(view, rays, counters)
                                      : CellRays::any_hit(view, rays, counters);
    RayPacket copy;
    PacketTracer<W, R, true> tracer(view, filled(rays, copy), counters, going);
    tracer.run();
    return tracer.occluded();
  }
};

/// W slots a node, R rays a register.
template <int W, int R>
constexpr Kernels kernel_table() {
  using Together = Packets<W, R, Going::together>;
  using Apart = Packets<W, R, Going::apart>;
  return {&Together::closest_hit, &Together::any_hit,       &Apart::closest_hit,
          &Apart::any_hit,        &BruteForce::closest_hit, W};
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
