#pragma once

#include <cmath>
#include <limits>

#include "regraft/core/vec.h"

namespace regraft {

/// Closed axis-aligned box [lo, hi]. Default: empty (lo > hi), the neutral element of `extend`.
struct Aabb {
  Vec3 lo{std::numeric_limits<float>::infinity()};
  Vec3 hi{-std::numeric_limits<float>::infinity()};

  /// Grows to hold `p`; a NaN coordinate is ignored.
  void extend(const Vec3& p) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = p[k] < lo[k] ? p[k] : lo[k];
      hi[k] = p[k] > hi[k] ? p[k] : hi[k];
    }
  }
  void extend(const Aabb& b) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = b.lo[k] < lo[k] ? b.lo[k] : lo[k];
      hi[k] = b.hi[k] > hi[k] ? b.hi[k] : hi[k];
    }
  }
  bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
  bool contains(const Aabb& b) const {
    return b.empty() || (lo.x <= b.lo.x && lo.y <= b.lo.y && lo.z <= b.lo.z && hi.x >= b.hi.x &&
                         hi.y >= b.hi.y && hi.z >= b.hi.z);
  }
  Vec3d extents() const { return empty() ? Vec3d(0.0) : Vec3d(hi) - Vec3d(lo); }
  /// Largest absolute coordinate; 0 for the empty box.
  float magnitude() const {
    if (empty()) return 0.0f;
    float m = 0.0f;
    for (int k = 0; k < 3; ++k) m = std::fmax(m, std::fmax(std::fabs(lo[k]), std::fabs(hi[k])));
    return m;
  }
  friend bool operator==(const Aabb&, const Aabb&) = default;
};

/// Half of the surface area, in double: float extents can neither overflow nor underflow it.
inline double half_area(const Aabb& b) {
  const Vec3d e = b.extents();
  return e.x * e.y + e.y * e.z + e.z * e.x;
}

/// Probability that a random line which hits `parent` hits `child`, in [0, 1]: the ratio of
/// areas, of edge lengths where the parent has no area, 1 where it is a point.
inline double hit_probability(const Aabb& child, const Aabb& parent) {
  const double area = half_area(parent);
  if (area > 0.0) return std::fmin(1.0, half_area(child) / area);
  const Vec3d c = child.extents();
  const Vec3d p = parent.extents();
  const double length = p.x + p.y + p.z;
  return length > 0.0 ? std::fmin(1.0, (c.x + c.y + c.z) / length) : 1.0;
}

}  // namespace regraft
