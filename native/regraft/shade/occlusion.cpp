#include "regraft/shade/occlusion.h"

#include <algorithm>
#include <cmath>

namespace regraft::shade {

namespace {

/// Directions about the normals, denser towards them (Malley's method), and lengths.
void make_rays(const SurfaceLanes& surface, const PointLanes& direction, const FloatLanes& reach,
               float radius, trace::RayPacket& rays) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float nx = surface.normal.x[i], ny = surface.normal.y[i], nz = surface.normal.z[i];
    const Frame3 frame(nx, ny, nz);
    float sine, cosine;
    sincos_turn(direction.v[i], sine, cosine);
    const float r = std::sqrt(direction.u[i]);
    const float up = std::sqrt(max_of(0.0f, 1.0f - direction.u[i]));
    const float a = r * cosine, b = r * sine;
    rays.direction[0][i] = a * frame.tx + b * frame.bx + up * nx;
    rays.direction[1][i] = a * frame.ty + b * frame.by + up * ny;
    rays.direction[2][i] = a * frame.tz + b * frame.bz + up * nz;
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = radius * reach[i];
  }
  for (int k = 0; k < 3; ++k)
    for (std::uint32_t i = 0; i < lane_count; ++i) rays.origin[k][i] = surface.position[k][i];
  rays.count = lane_count;
  rays.active = surface.active;
}

}  // namespace

float occlusion_radius(const Vec3d& lo, const Vec3d& hi) {
  if (!(lo.x <= hi.x)) return 0.0f;
  const Vec3d extent = hi - lo;
  const double longest = std::max({extent.x, extent.y, extent.z});
  double product = 1.0;
  for (int k = 0; k < 3; ++k) product *= std::cbrt(std::max(extent[k], 0.01 * longest));
  return float(0.25 * product);
}

Occlusion::Occlusion(float radius, std::uint32_t samples, std::uint64_t seed)
    : radius_(radius),
      rays_(std::max(1u, (occlusion_rays + samples - 1) / samples)),
      sampler_(seed, samples * rays_) {}

void Occlusion::openness(const SurfaceLanes& surface, std::uint32_t x0, std::uint32_t y0,
                         std::uint32_t sample, TalliedTracer& tracer, FloatLanes& open) const {
  FloatLanes free;
  open.fill(0.0f);
  trace::RayPacket rays;
  PointLanes direction;
  FloatLanes reach;
  for (std::uint32_t ray = 0; ray < rays_; ++ray) {
    const std::uint32_t number = sample * rays_ + ray;
    sampler_.points(x0, y0, number, std::uint32_t(Dimension::occlusion), direction);
    sampler_.numbers(x0, y0, number, std::uint32_t(Dimension::reach), reach);
    make_rays(surface, direction, reach, radius_, rays);
    const LaneMask blocked = tracer.secondary_any(rays);
    set_weights(~blocked, free);
    for (std::uint32_t i = 0; i < lane_count; ++i) open[i] += free[i];
  }
  for (float& value : open.value) value /= float(rays_);
}

}  // namespace regraft::shade
