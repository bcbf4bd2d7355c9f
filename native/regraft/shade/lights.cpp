#include "regraft/shade/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace regraft::shade {

namespace {

constexpr float pi = std::numbers::pi_v<float>;

/// Watt to radiant intensity on the axis. A point or spot light spreads its power over the
/// sphere, an area light over the half space with Lambert's cosine.
float intensity_per_watt(LightKind kind) {
  switch (kind) {
    case LightKind::point:
    case LightKind::spot:
      return 1.0f / (4.0f * pi);
    case LightKind::area:
      return 1.0f / pi;
    case LightKind::sun:
      break;
  }
  return 1.0f;
}

PreparedLight prepare(const Light& light) {
  PreparedLight out;
  out.light = light;
  out.intensity = light.color * (light.energy * intensity_per_watt(light.kind));
  if (light.kind == LightKind::spot) {
    out.cos_half_angle = std::cos(0.5f * light.spot_angle);
    out.spot_scale = 1.0f / std::max((1.0f - out.cos_half_angle) * light.spot_blend, 1e-6f);
  }
  if (light.kind == LightKind::sun) {
    const Vec3d aside = std::fabs(light.direction.z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(1, 0, 0);
    out.across_x = glm::normalize(glm::cross(light.direction, aside));
    out.across_y = glm::cross(light.direction, out.across_x);
  }
  return out;
}

bool has_effect(const Light& light) {
  return std::isfinite(light.energy) && light.energy > 0.0f &&
         (light.color.x > 0.0f || light.color.y > 0.0f || light.color.z > 0.0f);
}

/// Points of the unit disk, evenly distributed, for points of the unit square.
void to_disk(const PointLanes& square, FloatLanes& x, FloatLanes& y) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    float sine, cosine;
    sincos_turn(square.v[i], sine, cosine);
    const float r = std::sqrt(square.u[i]);
    x[i] = r * cosine;
    y[i] = r * sine;
  }
}

void set_target(const Vec3d& position, Illumination& out) {
  for (int k = 0; k < 3; ++k) out.target[k].fill(position[k]);
}

/// Points of a lamp's sphere: on the disk through its centre that faces the surface point, which
/// has the same outline.
void sample_sphere(const Light& light, const SurfaceLanes& surface, const PointLanes& sample,
                   Illumination& out) {
  FloatLanes x, y;
  to_disk(sample, x, y);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    float d[3];
    for (int k = 0; k < 3; ++k) d[k] = float(surface.position[k][i] - light.position[k]);
    const float length2 = d[0] * d[0] + (d[1] * d[1] + d[2] * d[2]);
    const float scale = 1.0f / std::sqrt(max_of(length2, 1e-30f));
    const Frame3 frame(d[0] * scale, d[1] * scale, d[2] * scale);
    const float a = light.radius * x[i], b = light.radius * y[i];
    out.target[0][i] = light.position.x + double(a * frame.tx + b * frame.bx);
    out.target[1][i] = light.position.y + double(a * frame.ty + b * frame.by);
    out.target[2][i] = light.position.z + double(a * frame.tz + b * frame.bz);
  }
}

void sample_rectangle(const Light& light, const PointLanes& sample, Illumination& out) {
  for (int k = 0; k < 3; ++k) {
    const double ax = light.axis_x[k] * double(light.size.x);
    const double ay = light.axis_y[k] * double(light.size.y);
    for (std::uint32_t i = 0; i < lane_count; ++i)
      out.target[k][i] =
          light.position[k] + ax * (double(sample.u[i]) - 0.5) + ay * (double(sample.v[i]) - 0.5);
  }
}

/// Unit vectors to the targets and the irradiance of a source that shines evenly all round:
/// 1 / (distance² + `soften2`).
void look_at_targets(const SurfaceLanes& surface, float soften2, Illumination& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float x = float(out.target[0][i] - surface.position[0][i]);
    const float y = float(out.target[1][i] - surface.position[1][i]);
    const float z = float(out.target[2][i] - surface.position[2][i]);
    const float length2 = max_of(x * x + (y * y + z * z), 1e-30f);
    const float inverse = 1.0f / std::sqrt(length2);
    out.to_light.x[i] = x * inverse;
    out.to_light.y[i] = y * inverse;
    out.to_light.z[i] = z * inverse;
    out.irradiance[i] = 1.0f / (length2 + soften2);
  }
}

/// Radius² of the disk that has the light's area. On its axis a disk gives the irradiance of a
/// point with distance² + radius² in place of distance²: with that, the centre stands for the
/// whole light even close by.
float soften2(const Light& light) {
  return light.kind == LightKind::area ? light.size.x * light.size.y / pi
                                       : light.radius * light.radius;
}

/// The sampled disk of a lamp is seen under an angle: its centre would be straight ahead.
void shape_sphere(const Light& light, const SurfaceLanes& surface, Illumination& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float x = float(light.position.x - surface.position[0][i]);
    const float y = float(light.position.y - surface.position[1][i]);
    const float z = float(light.position.z - surface.position[2][i]);
    const float inverse = 1.0f / std::sqrt(max_of(x * x + (y * y + z * z), 1e-30f));
    out.irradiance[i] *= inverse * max_of(0.0f, x * out.to_light.x[i] + y * out.to_light.y[i] +
                                                    z * out.to_light.z[i]);
  }
}

/// Soft-edged cone, as Blender shapes it: smoothstep over the cosine.
void shape_spot(const PreparedLight& light, Illumination& out) {
  const Vec3 axis(light.light.direction);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float cosine =
        -(axis.x * out.to_light.x[i] + axis.y * out.to_light.y[i] + axis.z * out.to_light.z[i]);
    const float raw = (cosine - light.cos_half_angle) * light.spot_scale;
    const float s = min_of(max_of(raw, 0.0f), 1.0f);
    out.irradiance[i] *= s * s * (3.0f - 2.0f * s);
  }
}

/// Lambert's cosine at the emitter, which shines to its front only.
void shape_area(const Light& light, Illumination& out) {
  const Vec3 axis(light.direction);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float cosine =
        -(axis.x * out.to_light.x[i] + axis.y * out.to_light.y[i] + axis.z * out.to_light.z[i]);
    out.irradiance[i] *= max_of(cosine, 0.0f);
  }
}

/// Parallel light; with a sample, from somewhere on the sun's disk.
void shine_sun(const PreparedLight& light, const PointLanes* sample, Illumination& out) {
  const Vec3 axis(-light.light.direction);
  const Vec3 ax(light.across_x), ay(light.across_y);
  FloatLanes x, y;
  if (sample != nullptr) {
    to_disk(*sample, x, y);
  } else {
    x.fill(0.0f);
    y.fill(0.0f);
  }
  const float spread = std::tan(min_of(light.light.radius, 1.5f));
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float a = spread * x[i], b = spread * y[i];
    const float dx = axis.x + (a * ax.x + b * ay.x);
    const float dy = axis.y + (a * ax.y + b * ay.y);
    const float dz = axis.z + (a * ax.z + b * ay.z);
    const float inverse = 1.0f / std::sqrt(dx * dx + (dy * dy + dz * dz));
    out.to_light.x[i] = dx * inverse;
    out.to_light.y[i] = dy * inverse;
    out.to_light.z[i] = dz * inverse;
    out.irradiance[i] = 1.0f;
  }
}

/// Lambert's cosine at the receiver; notes who is lit.
void receive(const SurfaceLanes& surface, Illumination& out) {
  const Vec3Lanes& n = surface.normal;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float cosine =
        n.x[i] * out.to_light.x[i] + (n.y[i] * out.to_light.y[i] + n.z[i] * out.to_light.z[i]);
    out.irradiance[i] *= max_of(cosine, 0.0f);
  }
  out.lit = lanes_above(out.irradiance, 0.0f) & surface.active;
}

}  // namespace

std::vector<PreparedLight> prepare_lights(std::span<const Light> lights) {
  std::vector<PreparedLight> out;
  for (const Light& light : lights)
    if (has_effect(light)) out.push_back(prepare(light));
  return out;
}

void illuminate(const PreparedLight& light, const SurfaceLanes& surface, const PointLanes* sample,
                Illumination& out) {
  const Light& source = light.light;
  if (source.kind == LightKind::sun) {
    shine_sun(light, sample, out);
    return receive(surface, out);
  }
  const bool area = source.kind == LightKind::area;
  if (sample == nullptr || (!area && source.radius <= 0.0f)) {
    set_target(source.position, out);
    look_at_targets(surface, soften2(source), out);
  } else if (area) {
    sample_rectangle(source, *sample, out);
    look_at_targets(surface, 0.0f, out);
  } else {
    sample_sphere(source, surface, *sample, out);
    look_at_targets(surface, 0.0f, out);
    shape_sphere(source, surface, out);
  }
  if (source.kind == LightKind::spot) shape_spot(light, out);
  if (area) shape_area(source, out);
  receive(surface, out);
}

}  // namespace regraft::shade
