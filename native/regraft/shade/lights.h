#pragma once

#include <span>
#include <vector>

#include "regraft/scene/light.h"
#include "regraft/shade/lanes.h"
#include "regraft/shade/sampler.h"
#include "regraft/shade/surface.h"

namespace regraft::shade {

/// A light ready for shading.
struct PreparedLight {
  Light light;
  /// Radiant intensity towards the front, W/sr (sun: irradiance, W/m²), times the colour.
  Vec3 intensity{0.0f};
  float cos_half_angle = -1.0f;
  float spot_scale = 0.0f;  ///< 1 / width of the soft rim, in cosines
  /// Two unit vectors across the direction a sun shines in.
  Vec3d across_x{0.0}, across_y{0.0};
};

/// What reaches 64 points from a light if nothing is in between.
struct Illumination {
  Vec3Lanes to_light;     ///< unit vectors
  FloatLanes irradiance;  ///< share of `intensity` a square metre facing along the normal gets
  DoubleLanes target[3];  ///< the point of the light looked at; unused for a sun
  LaneMask lit = 0;       ///< lanes with any irradiance
};

/// The lights that can have an effect at all, in order.
std::vector<PreparedLight> prepare_lights(std::span<const Light> lights);

/// Light that travels to `surface` from the point of the light chosen by `sample` (the unit
/// square), or from its centre if that is null. Units as in Blender: a white diffuse surface
/// shows irradiance · intensity / π.
void illuminate(const PreparedLight& light, const SurfaceLanes& surface, const PointLanes* sample,
                Illumination& out);

/// True if every ray towards the light ends in one point when its centre is sampled.
inline bool is_local(const PreparedLight& light) {
  return light.light.kind != LightKind::sun;
}

/// True if the light is more than a point: several samples then give soft shadows.
inline bool has_extent(const PreparedLight& light) {
  return light.light.kind == LightKind::area || light.light.radius > 0.0f;
}

}  // namespace regraft::shade
