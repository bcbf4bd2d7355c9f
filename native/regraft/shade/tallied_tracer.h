#pragma once

#include <chrono>
#include <cstdint>
#include <type_traits>

#include "regraft/shade/lanes.h"
#include "regraft/trace/tracer.h"

namespace regraft::shade {

/// What tracing for a picture took, by what the rays were for.
struct RayTally {
  trace::TraceCounters primary;
  trace::TraceCounters shadow;
  trace::TraceCounters secondary;
  std::int64_t trace_ns = 0;

  RayTally& operator+=(const RayTally& o) {
    primary += o.primary;
    shadow += o.shadow;
    secondary += o.secondary;
    trace_ns += o.trace_ns;
    return *this;
  }
};

/// A tracer that keeps the books of one worker.
class TalliedTracer {
 public:
  explicit TalliedTracer(const trace::Tracer& tracer) : tracer_(tracer) {}

  void primary(const trace::RayPacket& rays, trace::HitPacket& hits) {
    timed([&] { tracer_.closest_hit(rays, hits, tally_.primary); });
  }
  void primary_with_cost(const trace::RayPacket& rays, trace::HitPacket& hits,
                         std::uint32_t* cost) {
    timed([&] { tracer_.closest_hit_single(rays, hits, tally_.primary, cost); });
  }
  void secondary(const trace::RayPacket& rays, trace::HitPacket& hits) {
    timed([&] { tracer_.closest_hit(rays, hits, tally_.secondary); });
  }
  /// Lanes whose incoherent ray hits anything.
  LaneMask secondary_any(const trace::RayPacket& rays) {
    return timed([&] { return tracer_.any_hit(rays, tally_.secondary); });
  }
  /// Lanes whose shadow ray hits anything.
  LaneMask shadow(const trace::RayPacket& rays) {
    return timed([&] { return tracer_.any_hit(rays, tally_.shadow); });
  }
  /// What the shadow rays meet first.
  void shadow_closest(const trace::RayPacket& rays, trace::HitPacket& hits) {
    timed([&] { tracer_.closest_hit(rays, hits, tally_.shadow); });
  }

  const RayTally& tally() const { return tally_; }

 private:
  template <typename Body>
  std::invoke_result_t<Body> timed(const Body& body) {
    const Stopwatch watch{tally_.trace_ns};
    return body();
  }
  struct Stopwatch {
    std::int64_t& total;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    ~Stopwatch() {
      total += std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count();
    }
  };

  trace::Tracer tracer_;
  RayTally tally_;
};

}  // namespace regraft::shade
