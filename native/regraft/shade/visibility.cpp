#include "regraft/shade/visibility.h"

#include <cmath>

namespace regraft::shade {

namespace {

/// Both ends of a ray between a surface and a light stay this share of its length away from what
/// the light itself may sit on.
constexpr float light_gap = 1e-5f;
/// A ray that starts at the light is rounded at the light's distance: its far end keeps so far
/// from the surface, as a share of that distance (see `offset_ratio` in surface.cpp).
constexpr float distance_ratio = 0x1p-19f;

/// Rays from the light's centre outwards. With a common origin the packet is a pyramid.
void rays_from_light(const SurfaceLanes& surface, const Illumination& illumination,
                     trace::RayPacket& rays) {
  FloatLanes lift;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float x = float(illumination.target[0][i] - surface.position[0][i]);
    const float y = float(illumination.target[1][i] - surface.position[1][i]);
    const float z = float(illumination.target[2][i] - surface.position[2][i]);
    lift[i] = distance_ratio * max_of(max_of(std::fabs(x), std::fabs(y)), std::fabs(z));
    rays.t_near[i] = light_gap;
    rays.t_far[i] = 1.0f;
  }
  const FloatLanes* normal[3] = {&surface.geometric.x, &surface.geometric.y, &surface.geometric.z};
  for (int k = 0; k < 3; ++k) {
    const FloatLanes& n = *normal[k];
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      rays.origin[k][i] = illumination.target[k][i];
      rays.direction[k][i] =
          (surface.position[k][i] - illumination.target[k][i]) + double(lift[i] * n[i]);
    }
  }
}

void rays_to_light(const SurfaceLanes& surface, const Illumination& illumination,
                   trace::RayPacket& rays) {
  for (int k = 0; k < 3; ++k)
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      rays.origin[k][i] = surface.position[k][i];
      rays.direction[k][i] = illumination.target[k][i] - surface.position[k][i];
    }
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = 1.0f - light_gap;
  }
}

void rays_to_sun(const SurfaceLanes& surface, const Illumination& illumination,
                 trace::RayPacket& rays) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    rays.direction[0][i] = illumination.to_light.x[i];
    rays.direction[1][i] = illumination.to_light.y[i];
    rays.direction[2][i] = illumination.to_light.z[i];
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = std::numeric_limits<float>::infinity();
  }
  for (int k = 0; k < 3; ++k)
    for (std::uint32_t i = 0; i < lane_count; ++i) rays.origin[k][i] = surface.position[k][i];
}

/// Dims `passed` by one layer of what was hit. @return lanes that still get light.
LaneMask pass_layer(const trace::HitPacket& hits, LaneMask lanes, InstanceCache& instances,
                    FloatLanes& passed) {
  LaneMask going = 0;
  for_each_lane(lanes, [&](std::uint32_t i) {
    if (hits.instance_id[i] == invalid_id) return;
    const ShadedInstance& instance = instances.find(hits.instance_id[i]);
    passed[i] *= max_of(0.0f, 1.0f - instances.material(instance, hits.prim_id[i]).base_color.w);
    if (passed[i] > 0.0f) going |= LaneMask(1) << i;
  });
  return going;
}

/// Follows shadow rays that hit something through transparent surfaces.
void pass_transparent(LaneMask blocked, trace::RayPacket& rays, TalliedTracer& tracer,
                      InstanceCache& instances, FloatLanes& passed) {
  trace::HitPacket hits;
  for_each_lane(blocked, [&](std::uint32_t i) { passed[i] = 1.0f; });
  rays.active = blocked;
  for (int layer = 0; layer < max_layers && rays.active != 0; ++layer) {
    tracer.shadow_closest(rays, hits);
    step_behind(hits, pass_layer(hits, rays.active, instances, passed), rays);
  }
  for_each_lane(rays.active, [&](std::uint32_t i) { passed[i] = 0.0f; });
}

}  // namespace

void shadows(const PreparedLight& light, const Illumination& illumination, bool from_centre,
             const SurfaceLanes& surface, Visibility visibility, TalliedTracer& tracer,
             InstanceCache& instances, FloatLanes& passed) {
  if (!light.light.cast_shadow) return set_weights(illumination.lit, passed);
  trace::RayPacket rays;
  if (!is_local(light))
    rays_to_sun(surface, illumination, rays);
  else if (from_centre)
    rays_from_light(surface, illumination, rays);
  else
    rays_to_light(surface, illumination, rays);
  rays.count = lane_count;
  rays.active = illumination.lit;
  const LaneMask blocked = tracer.shadow(rays);
  set_weights(illumination.lit & ~blocked, passed);
  if (visibility.transparency && blocked != 0)
    pass_transparent(blocked, rays, tracer, instances, passed);
}

}  // namespace regraft::shade
