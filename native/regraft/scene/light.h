#pragma once

#include <cstdint>

#include "regraft/core/vec.h"

namespace regraft {

enum class LightKind : std::uint8_t { point, spot, sun, area };

/// World frame; energy in watt, for the sun in W/m² (as in Blender).
struct Light {
  LightKind kind = LightKind::point;
  Vec3d position{0.0};
  /// Unit vector, where the light looks.
  Vec3d direction{0.0, 0.0, -1.0};
  Vec3 color{1.0f};
  float energy = 10.0f;
  /// Sphere radius (point, spot) or angular radius in radians (sun).
  float radius = 0.0f;
  float spot_angle = 0.785398f;
  float spot_blend = 0.15f;
  /// Unit edges of an area light and its size along them.
  Vec3d axis_x{1.0, 0.0, 0.0};
  Vec3d axis_y{0.0, 1.0, 0.0};
  Vec2 size{1.0f, 1.0f};
  bool cast_shadow = true;
};

}  // namespace regraft
