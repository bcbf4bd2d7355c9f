#include "regraft/trace/tracer.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "regraft/scene/mesh.h"
#include "regraft/trace/kernels.h"

namespace regraft::trace {

const Kernels& kernels(simd::Isa isa) {
  const auto isas = simd::available_isas();
  if (std::find(isas.begin(), isas.end(), isa) == isas.end())
    throw std::invalid_argument("this machine does not have the instruction set " +
                                std::string(simd::name(isa)));
  switch (isa) {
#if defined(__x86_64__)
    case simd::Isa::sse:
      return kernels_sse;
    case simd::Isa::avx2:
      return kernels_avx2;
    case simd::Isa::avx512:
      return kernels_avx512;
#endif
    default:
      return kernels_scalar;
  }
}

bool has_area(const MeshView& mesh, std::uint32_t prim) {
  Vec3 corner[3];
  for (std::size_t c = 0; c < 3; ++c) {
    const float* p = mesh.vertices + 3 * std::size_t(mesh.triangles[3 * std::size_t(prim) + c]);
    corner[c] = {p[0], p[1], p[2]};
  }
  return !is_degenerate(corner[0], corner[1], corner[2]);
}

Tracer::Tracer(const TraceView& view, simd::Isa isa) : view_(&view), kernels_(&kernels(isa)) {}

void Tracer::closest_hit(const RayPacket& rays, HitPacket& hits, TraceCounters& counters) const {
  kernels_->closest_hit(*view_, rays, hits, counters);
}

std::uint64_t Tracer::any_hit(const RayPacket& rays, TraceCounters& counters) const {
  return kernels_->any_hit(*view_, rays, counters);
}

void Tracer::closest_hit_single(const RayPacket& rays, HitPacket& hits, TraceCounters& counters,
                                std::uint32_t* cost) const {
  kernels_->closest_hit_single(*view_, rays, hits, counters, cost);
}

void Tracer::brute_force(const RayPacket& rays, HitPacket& hits, TraceCounters& counters) const {
  kernels_->brute_force(*view_, rays, hits, counters);
}

std::uint64_t Tracer::any_hit_single(const RayPacket& rays, TraceCounters& counters) const {
  return kernels_->any_hit_single(*view_, rays, counters);
}

PointHit Tracer::closest_point(const Vec3d& p, double max_distance) const {
  return trace::closest_point(*view_, p, max_distance);
}

}  // namespace regraft::trace
