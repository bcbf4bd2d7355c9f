#include "regraft/kdtree/clip.h"

#include <cmath>
#include <utility>

#include "regraft/core/rounding.h"

namespace regraft::kdtree {

namespace {

/// A triangle cut by six planes has at most nine corners.
struct Polygon {
  Vec3d corner[9];
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

/// The triangle's own box, cut to the voxel; what most triangles of a leaf need, being inside it.
struct Extent {
  Vec3d lo, hi;

  void extend(const Vec3d& p) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = p[k] < lo[k] ? p[k] : lo[k];
      hi[k] = p[k] > hi[k] ? p[k] : hi[k];
    }
  }
  Aabb within(const Vec3d& margin, const Aabb& voxel) const {
    Aabb box;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = std::fmax(round_down(lo[k] - margin[k]), voxel.lo[k]);
      box.hi[k] = std::fmin(round_up(hi[k] + margin[k]), voxel.hi[k]);
    }
    return box.empty() ? Aabb{} : box;
  }
};

}  // namespace

Aabb clip_triangle(const Vec3d (&corners)[3], const Vec3d& margin, const Aabb& voxel) {
  Extent whole{corners[0], corners[0]};
  whole.extend(corners[1]);
  whole.extend(corners[2]);
  Polygon polygon{{corners[0], corners[1], corners[2]}, 3};
  Polygon other;
  double largest = 0.0;
  for (int k = 0; k < 3; ++k)
    largest = std::fmax(largest, std::fmax(std::fabs(whole.lo[k]), std::fabs(whole.hi[k])));
  for (int k = 0; k < 3 && polygon.count > 0; ++k) {
    // Far beyond the rounding of one intersection, far below that of a ray.
    const double slack = margin[k] + 0x1p-48 * largest;
    const double lo = double(voxel.lo[k]) - slack, hi = double(voxel.hi[k]) + slack;
    if (whole.lo[k] < lo) {
      clip_side(polygon, k, 1.0, lo, other);
      std::swap(polygon, other);
    }
    if (whole.hi[k] > hi) {
      clip_side(polygon, k, -1.0, hi, other);
      std::swap(polygon, other);
    }
  }
  if (polygon.count == 0) return {};
  Extent part{polygon.corner[0], polygon.corner[0]};
  for (int i = 1; i < polygon.count; ++i) part.extend(polygon.corner[i]);
  return part.within(margin, voxel);
}

}  // namespace regraft::kdtree
