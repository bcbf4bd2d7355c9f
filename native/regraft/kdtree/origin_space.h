#pragma once

#include <algorithm>

#include "regraft/core/aabb.h"

namespace regraft::kdtree {

inline Aabb clipped(const Aabb& box, const Aabb& to) {
  Aabb part;
  for (int k = 0; k < 3; ++k) {
    part.lo[k] = std::max(box.lo[k], to.lo[k]);
    part.hi[k] = std::min(box.hi[k], to.hi[k]);
  }
  return part;
}

/// The box S of ray origins moved to the origin and scaled to largest extent 1, and a box N
/// clipped to it. In double, so that extents of 1e±30 neither overflow nor underflow products.
struct OriginSpace {
  OriginSpace() = default;
  /// `origins` has some extent.
  OriginSpace(const Aabb& origins, const Aabb& box) {
    const Vec3d extents = origins.extents();
    scale = 1.0 / std::max({extents.x, extents.y, extents.z});
    zero = Vec3d(origins.lo);
    size = extents * scale;
    for (int k = 0; k < 3; ++k) {
      lo[k] = (std::max(origins.lo[k], box.lo[k]) - zero[k]) * scale;
      hi[k] = (std::min(origins.hi[k], box.hi[k]) - zero[k]) * scale;
    }
  }

  /// A coordinate of the scene, here.
  double place(int axis, double position) const { return (position - zero[axis]) * scale; }
  bool misses() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  double volume() const { return size.x * size.y * size.z; }
  double face_area(int axis) const {
    const int i = (axis + 1) % 3;
    const int j = (axis + 2) % 3;
    return (hi[i] - lo[i]) * (hi[j] - lo[j]);
  }
  double box_volume() const { return face_area(0) * (hi.x - lo.x); }
  /// Distance from the faces of N across `axis` to those of S beyond them.
  double gap_below(int axis) const { return lo[axis]; }
  double gap_above(int axis) const { return size[axis] - hi[axis]; }
  /// m of Fabianowski et al. 2009, eq. 10: of the slab of S `thickness` thick beyond a face of N
  /// across `axis`, the chance that its rays leave through the face, times its volume, over the
  /// face's area.
  double slab_weight(int axis, double thickness) const {
    const double a = size[(axis + 1) % 3];
    const double b = size[(axis + 2) % 3];
    return thickness * a * b / (2.0 * (a * b + thickness * (a + b)));
  }

  Vec3d size{0.0};
  Vec3d lo{0.0};  ///< of N
  Vec3d hi{0.0};  ///< of N
  Vec3d zero{0.0};
  double scale = 1.0;
};

}  // namespace regraft::kdtree
