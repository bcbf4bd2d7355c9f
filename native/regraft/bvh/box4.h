#pragma once

#include <limits>

#include "regraft/core/aabb.h"
#include "regraft/simd/gather.h"

namespace regraft::bvh {

using Float4 = simd::REGRAFT_SIMD_NAMESPACE::Float<4>;

/// A box in two registers; the fourth lane is zero. Default: empty.
struct Box4 {
  Float4 lo{std::numeric_limits<float>::infinity()};
  Float4 hi{-std::numeric_limits<float>::infinity()};

  Box4() = default;
  Box4(Float4 l, Float4 h) : lo(l), hi(h) {}
  explicit Box4(const Aabb& b)
      : lo(simd::REGRAFT_SIMD_NAMESPACE::load_point(&b.lo.x)),
        hi(simd::REGRAFT_SIMD_NAMESPACE::load_point(&b.hi.x)) {}

  void extend(Float4 other_lo, Float4 other_hi) {
    lo = min(other_lo, lo);
    hi = max(other_hi, hi);
  }
  void extend(const Box4& other) { extend(other.lo, other.hi); }
  /// As `half_area` of core/aabb.h, for boxes that are not empty.
  double half_area() const {
    alignas(16) float l[4], h[4];
    lo.store(l);
    hi.store(h);
    const double x = double(h[0]) - double(l[0]), y = double(h[1]) - double(l[1]),
                 z = double(h[2]) - double(l[2]);
    return x * y + y * z + z * x;
  }
  Aabb aabb() const {
    alignas(16) float l[4], h[4];
    lo.store(l);
    hi.store(h);
    return {Vec3(l[0], l[1], l[2]), Vec3(h[0], h[1], h[2])};
  }
};

}  // namespace regraft::bvh
