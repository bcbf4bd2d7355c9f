#pragma once

#include "regraft/core/aabb.h"

namespace regraft::kdtree {

/// Box of the part of a triangle that lies within `margin` of a voxel, axis by axis, widened by the
/// margin and cut to the voxel; empty if there is none.
///
/// Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 17, 1974, in double precision; the result
/// is rounded outward, so what touches the voxel is never lost.
Aabb clip_triangle(const Vec3d (&corners)[3], const Vec3d& margin, const Aabb& voxel);

/// Boxes of what both sides of a plane across `axis` keep of the part of a triangle in `box`. Only
/// the plane cuts the triangle, and `box` what that leaves: a little wider than `clip_triangle`,
/// for a third of its work.
void clip_triangle_sides(const Vec3d (&corners)[3], const Vec3d& margin, const Aabb& box, int axis,
                         float position, Aabb (&sides)[2]);

}  // namespace regraft::kdtree
