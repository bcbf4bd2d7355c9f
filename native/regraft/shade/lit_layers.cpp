// The lit modes of TileShader: lights and their shadows, one mirror, transparent layers.

#include <cmath>

#include "regraft/shade/preview_shading.h"

namespace regraft::shade {

namespace {

/// The mirror image's lights draw their samples from dimensions of their own.
constexpr std::uint32_t mirrored_dimensions = 1u << 16;

/// Weights of a layer: its coverage of what the layers before have left; `left` becomes the rest.
void cover(const FloatLanes& alpha, LaneMask lanes, FloatLanes& left, FloatLanes& weight) {
  FloatLanes here;
  set_weights(lanes, here);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    weight[i] = left[i] * (here[i] * min_of(max_of(alpha[i], 0.0f), 1.0f));
    left[i] -= weight[i];
  }
}

void add_weighted(const FloatLanes& weight, const Vec3Lanes& color, Vec3Lanes& sum) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    sum.x[i] += weight[i] * color.x[i];
    sum.y[i] += weight[i] * color.y[i];
    sum.z[i] += weight[i] * color.z[i];
  }
}

/// Share of the world's light that reaches a surface: more from above than from below, and never
/// all of it, as no ray asks what is in its way. Also, an unlit white surface would else be of
/// exactly the background's colour.
float ambient_share(float normal_z) {
  return 0.55f + 0.25f * normal_z;
}

/// What surfaces send out without any light: their own, and what they scatter of the world's.
void start_radiance(const MaterialLanes& m, const FloatLanes& normal_z, const FloatLanes& mirrored,
                    const Vec3& world, Vec3Lanes& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float scattered = ambient_share(normal_z[i]) * (1.0f - mirrored[i]);
    out.x[i] = m.emission.x[i] + m.base.x[i] * (world.x * scattered);
    out.y[i] = m.emission.y[i] + m.base.y[i] * (world.y * scattered);
    out.z[i] = m.emission.z[i] + m.base.z[i] * (world.z * scattered);
  }
}

/// A light of irradiance π at the viewer's own place, which throws no shadow it could see.
void add_headlight(const SurfaceLanes& surface, const ReflectanceLanes& reflectance,
                   Vec3Lanes& radiance) {
  PreparedLight light;
  light.intensity = Vec3(3.14159265f);
  Illumination illumination;
  FloatLanes passed;
  passed.fill(1.0f);
  illumination.to_light = surface.view;
  illumination.irradiance = reflectance.normal_view;
  add_light(light, illumination, passed, surface, reflectance, radiance);
}

/// Mirrored directions. Where a shading normal sends one below the triangle, it is thrown back
/// above: there is nothing to see inside.
void make_mirror_rays(const SurfaceLanes& s, LaneMask active, trace::RayPacket& rays) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float nx = s.normal.x[i], ny = s.normal.y[i], nz = s.normal.z[i];
    const float gx = s.geometric.x[i], gy = s.geometric.y[i], gz = s.geometric.z[i];
    const float twice = 2.0f * (s.view.x[i] * nx + (s.view.y[i] * ny + s.view.z[i] * nz));
    const float x = twice * nx - s.view.x[i];
    const float y = twice * ny - s.view.y[i];
    const float z = twice * nz - s.view.z[i];
    const float below = 2.0f * min_of(0.0f, x * gx + (y * gy + z * gz));
    rays.direction[0][i] = x - below * gx;
    rays.direction[1][i] = y - below * gy;
    rays.direction[2][i] = z - below * gz;
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = std::numeric_limits<float>::infinity();
  }
  for (int k = 0; k < 3; ++k)
    for (std::uint32_t i = 0; i < lane_count; ++i) rays.origin[k][i] = s.position[k][i];
  rays.count = lane_count;
  rays.active = active;
}

}  // namespace

/// Composites what the rays meet, front to back; with opaque materials the first layer is all.
/// `sight.surface` must be found where `sight.hit` says so. The rays are used up. `world_alpha`:
/// how much of the world is seen behind everything.
void TileShader::lit_layers(Sight& sight, bool mirrors, float world_alpha, Layers& out) {
  FloatLanes left, weight;
  left.fill(1.0f);
  out.color = Vec3Lanes{};
  for (int layer = 1; sight.hit != 0; ++layer) {
    const bool last = !picture_.visibility.transparency || layer == max_layers;
    MaterialLanes material;
    Vec3Lanes radiance;
    read_materials(sight.surface, material);
    shade(sight.surface, material, mirrors, radiance);
    if (last) material.alpha.fill(1.0f);
    cover(material.alpha, sight.hit, left, weight);
    add_weighted(weight, radiance, out.color);
    const LaneMask going = lanes_above(left, 0.0f) & sight.hit;
    if (going == 0) break;
    step_behind(sight.hits, going, sight.rays);
    tracer_.secondary(sight.rays, sight.hits);
    sight.hit = hit_lanes(sight.hits, going);
    if (sight.hit != 0)
      find_surfaces(sight.rays, sight.hits, sight.hit, {true, true}, instances_, sight.surface);
  }
  const Vec3 world = picture_.world * world_alpha;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    out.color.x[i] += left[i] * world.x;
    out.color.y[i] += left[i] * world.y;
    out.color.z[i] += left[i] * world.z;
    out.alpha[i] = 1.0f - left[i] * (1.0f - world_alpha);
  }
}

/// Radiance of opaque surfaces towards the viewer.
void TileShader::shade(const SurfaceLanes& surface, const MaterialLanes& material, bool mirrors,
                       Vec3Lanes& radiance) {
  FloatLanes mirrored;
  if (mirrors)
    mirror_share(surface, material, mirrored);
  else
    mirrored.fill(0.0f);
  ReflectanceLanes reflectance;
  prepare_reflectance(surface, material, mirrored, reflectance);
  start_radiance(material, surface.normal.z, mirrored, picture_.world, radiance);
  add_lights(surface, reflectance, mirrors, radiance);
  if (mirrors) add_mirror(surface, material, mirrored, radiance);
}

void TileShader::add_lights(const SurfaceLanes& surface, const ReflectanceLanes& reflectance,
                            bool mirrors, Vec3Lanes& radiance) {
  if (picture_.headlight) return add_headlight(surface, reflectance, radiance);
  const bool soft = picture_.settings.samples > 1;
  const bool mirrored = picture_.settings.shading == Shading::reflection && !mirrors;
  std::uint32_t dimension =
      std::uint32_t(Dimension::first_light) + (mirrored ? mirrored_dimensions : 0);
  PointLanes sample;
  Illumination illumination;
  FloatLanes passed;
  for (const PreparedLight& light : picture_.lights) {
    const bool spread = soft && has_extent(light);
    if (spread) picture_.sampler.points(tile_.x0, tile_.y0, sample_, dimension, sample);
    ++dimension;
    illuminate(light, surface, spread ? &sample : nullptr, illumination);
    if (illumination.lit == 0) continue;
    shadows(light, illumination, !spread, surface, picture_.visibility, tracer_, instances_,
            passed);
    add_light(light, illumination, passed, surface, reflectance, radiance);
  }
}

void TileShader::add_mirror(const SurfaceLanes& surface, const MaterialLanes& material,
                            const FloatLanes& share, Vec3Lanes& radiance) {
  const LaneMask lanes = lanes_above(share, 0.0f) & surface.active;
  if (lanes == 0) return;
  Sight sight;
  Layers image;
  make_mirror_rays(surface, lanes, sight.rays);
  tracer_.secondary(sight.rays, sight.hits);
  sight.hit = hit_lanes(sight.hits, lanes);
  if (sight.hit != 0)
    find_surfaces(sight.rays, sight.hits, sight.hit, {true, true}, instances_, sight.surface);
  lit_layers(sight, false, 1.0f, image);
  FloatLanes weight;
  set_weights(lanes, weight);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float mirrored = weight[i] * share[i], metal = material.metallic[i];
    radiance.x[i] += mirrored * image.color.x[i] * (1.0f + metal * (material.base.x[i] - 1.0f));
    radiance.y[i] += mirrored * image.color.y[i] * (1.0f + metal * (material.base.y[i] - 1.0f));
    radiance.z[i] += mirrored * image.color.z[i] * (1.0f + metal * (material.base.z[i] - 1.0f));
  }
}

}  // namespace regraft::shade
