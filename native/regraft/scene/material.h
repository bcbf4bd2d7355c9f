#pragma once

#include "regraft/core/vec.h"

namespace regraft {

/// What preview shading knows of a surface; colours linear.
struct Material {
  Vec4 base_color{0.8f, 0.8f, 0.8f, 1.0f};
  Vec3 emission{0.0f};
  float metallic = 0.0f;
  float roughness = 0.5f;
  friend bool operator==(const Material&, const Material&) = default;
};

}  // namespace regraft
