#pragma once

#include "regraft/core/vec.h"

namespace regraft::kdtree {

/// Solid angle of the triangle abc seen from the origin: Van Oosterom and Strackee, The solid
/// angle of a plane triangle, 1983. Its numerator is taken from edges: as a triple product of
/// positions it loses all digits where the triangle is far away or seen edge on.
double triangle_solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// Solid angle of the box [lo, hi] seen from `eye`; 4π from its inside.
double box_solid_angle(const Vec3d& lo, const Vec3d& hi, const Vec3d& eye);

}  // namespace regraft::kdtree
