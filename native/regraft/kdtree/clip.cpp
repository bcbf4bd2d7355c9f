#include "regraft/kdtree/clip.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "regraft/core/rounding.h"

namespace regraft::kdtree {

namespace {

/// Of the largest coordinate: far beyond the rounding of one intersection, far below that of a ray.
constexpr double rounding = 0x1p-48;

/// A triangle cut by six planes has at most nine corners.
struct Polygon {
  Vec3d corner[9];  // not initialised: few are used
  int count = 0;

  void add(const Vec3d& p) { corner[count++] = p; }
};

/// Keeps what lies at or above `plane` along `sign`·axis.
void clip_side(const Polygon& in, int axis, double sign, double plane, Polygon& out) {
  out.count = 0;
  for (int i = 0; i < in.count; ++i) {
    const Vec3d& a = in.corner[i];
    const Vec3d& b = in.corner[i + 1 == in.count ? 0 : i + 1];
    const double from = sign * (a[axis] - plane);
    const double to = sign * (b[axis] - plane);
    if (from >= 0.0) out.add(a);
    if ((from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0)) {
      Vec3d p = a + (from / (from - to)) * (b - a);
      p[axis] = plane;
      out.add(p);
    }
  }
}

struct Extent {
  Vec3d lo{std::numeric_limits<double>::infinity()};
  Vec3d hi{-std::numeric_limits<double>::infinity()};

  void extend(const Vec3d& p) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = p[k] < lo[k] ? p[k] : lo[k];
      hi[k] = p[k] > hi[k] ? p[k] : hi[k];
    }
  }
  Aabb within(const Vec3d& margin, const Aabb& voxel) const {
    Aabb box;
    for (int k = 0; k < 3; ++k) {
      // fmax is a call; nothing here is NaN.
      const float below = round_down(lo[k] - margin[k]);
      const float above = round_up(hi[k] + margin[k]);
      box.lo[k] = below > voxel.lo[k] ? below : voxel.lo[k];
      box.hi[k] = above < voxel.hi[k] ? above : voxel.hi[k];
    }
    return box.empty() ? Aabb{} : box;
  }
};

/// Extent of what of a triangle lies at or above `plane` along `sign`·axis.
Extent part_beyond(const Vec3d (&corners)[3], int axis, double sign, double plane) {
  Extent part;
  for (int i = 0; i < 3; ++i) {
    const Vec3d& a = corners[i];
    const Vec3d& b = corners[i == 2 ? 0 : i + 1];
    const double from = sign * (a[axis] - plane);
    const double to = sign * (b[axis] - plane);
    if (from >= 0.0) part.extend(a);
    if ((from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0)) {
      Vec3d p = a + (from / (from - to)) * (b - a);
      p[axis] = plane;
      part.extend(p);
    }
  }
  return part;
}

/// A triangle while it is clipped. Where it does not reach beyond a plane nothing is done.
class Clipping {
 public:
  Clipping(const Vec3d (&corners)[3], const Vec3d& margin) : margin_(margin) {
    for (const Vec3d& corner : corners) {
      room_[0].add(corner);
      whole_.extend(corner);
      for (int k = 0; k < 3; ++k) {
        const double size = std::fabs(corner[k]);
        largest_ = size > largest_ ? size : largest_;
      }
    }
  }

  void to_voxel(const Aabb& voxel) {
    for (int k = 0; k < 3 && polygon().count > 0; ++k) {
      above(k, double(voxel.lo[k]));
      below(k, double(voxel.hi[k]));
    }
  }
  void above(int axis, double plane) {
    const double lo = plane - slack(axis);
    if (whole_.lo[axis] < lo) clip(axis, 1.0, lo);
  }
  void below(int axis, double plane) {
    const double hi = plane + slack(axis);
    if (whole_.hi[axis] > hi) clip(axis, -1.0, hi);
  }

  Aabb within(const Aabb& voxel) const {
    Extent part;
    for (int i = 0; i < polygon().count; ++i) part.extend(polygon().corner[i]);
    return polygon().count > 0 ? part.within(margin_, voxel) : Aabb{};
  }

 private:
  const Polygon& polygon() const { return room_[at_]; }
  double slack(int axis) const { return margin_[axis] + rounding * largest_; }
  void clip(int axis, double sign, double plane) {
    clip_side(room_[at_], axis, sign, plane, room_[1 - at_]);
    at_ = 1 - at_;
  }

  Polygon room_[2];
  int at_ = 0;
  Extent whole_;
  Vec3d margin_;
  double largest_ = 0.0;
};

}  // namespace

Aabb clip_triangle(const Vec3d (&corners)[3], const Vec3d& margin, const Aabb& voxel) {
  Clipping clipping(corners, margin);
  clipping.to_voxel(voxel);
  return clipping.within(voxel);
}

void clip_triangle_sides(const Vec3d (&corners)[3], const Vec3d& margin, const Aabb& box, int axis,
                         float position, Aabb (&sides)[2]) {
  double largest = 0.0;
  for (const Vec3d& corner : corners)
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(corner[k]));
  const double slack = margin[axis] + rounding * largest;
  for (int s = 0; s < 2; ++s) {
    const double sign = s == 0 ? -1.0 : 1.0;
    Aabb side = box;
    (s == 0 ? side.hi : side.lo)[axis] = position;
    sides[s] =
        part_beyond(corners, axis, sign, double(position) - sign * slack).within(margin, side);
  }
}

}  // namespace regraft::kdtree
