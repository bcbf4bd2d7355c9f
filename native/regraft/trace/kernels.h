#pragma once

#include <cstdint>

#include "regraft/simd/dispatch.h"
#include "regraft/trace/hit.h"
#include "regraft/trace/trace_view.h"

namespace regraft::trace {

/// The query kernels of one instruction set. `cost` may be null.
struct Kernels {
  void (*closest_hit)(const TraceView&, const RayPacket&, HitPacket&, TraceCounters&);
  std::uint64_t (*any_hit)(const TraceView&, const RayPacket&, TraceCounters&);
  void (*closest_hit_single)(const TraceView&, const RayPacket&, HitPacket&, TraceCounters&,
                             std::uint32_t* cost);
  std::uint64_t (*any_hit_single)(const TraceView&, const RayPacket&, TraceCounters&);
  /// Every ray against every triangle, without any tree.
  void (*brute_force)(const TraceView&, const RayPacket&, HitPacket&, TraceCounters&);
  /// Slots of the wide nodes these kernels read.
  int width;
};

/// Throws std::invalid_argument if this build or machine lacks the instruction set.
const Kernels& kernels(simd::Isa isa);

extern const Kernels kernels_scalar;
extern const Kernels kernels_sse;
extern const Kernels kernels_avx2;
extern const Kernels kernels_avx512;

}  // namespace regraft::trace
