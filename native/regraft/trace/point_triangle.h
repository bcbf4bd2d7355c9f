#pragma once

#include "regraft/core/vec.h"

namespace regraft::trace {

/// Weights (v, w) of the second and third corner in the point of the triangle nearest to `p`, by
/// the region of the plane it lies over (Ericson, Real-Time Collision Detection, 2005, section
/// 5.1.5).
glm::dvec2 nearest_weights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace regraft::trace
