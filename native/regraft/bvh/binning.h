#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "regraft/core/aabb.h"
#include "regraft/simd/float_n.h"

namespace regraft::bvh {

using Float4 = simd::REGRAFT_SIMD_NAMESPACE::Float<4>;

/// A primitive while a tree is built: its box and its id in the spare lane.
struct alignas(32) PrimRef {
  float lo[3];
  std::uint32_t id;
  float hi[3];
  std::uint32_t padding;

  Float4 lo4() const { return Float4::load(lo); }
  Float4 hi4() const { return Float4::load(hi); }
  /// Halved before they are added, so that boxes near the largest float do not overflow.
  Float4 centroid4() const { return Float4(0.5f) * lo4() + Float4(0.5f) * hi4(); }
  float centroid(int axis) const { return 0.5f * lo[axis] + 0.5f * hi[axis]; }
};

/// A box in two registers; the fourth lane holds rubbish.
struct Box4 {
  Float4 lo{std::numeric_limits<float>::infinity()};
  Float4 hi{-std::numeric_limits<float>::infinity()};

  void extend(Float4 other_lo, Float4 other_hi) {
    lo = min(other_lo, lo);
    hi = max(other_hi, hi);
  }
  void extend(const Box4& other) { extend(other.lo, other.hi); }
  Aabb aabb() const {
    alignas(16) float l[4], h[4];
    lo.store(l);
    hi.store(h);
    return {Vec3(l[0], l[1], l[2]), Vec3(h[0], h[1], h[2])};
  }
};

inline constexpr int bin_count = 16;

/// Maps centroids to bins on all three axes at once.
class BinMapping {
 public:
  explicit BinMapping(const Aabb& centroids) {
    for (int k = 0; k < 3; ++k) {
      const float extent = centroids.hi[k] - centroids.lo[k];
      const float scale = 0.999f * bin_count / extent;
      // Denormal or overflowing extents cannot be binned; such ranges fall back to the median.
      usable_[k] = extent > 0.0f && std::isfinite(scale) && scale > 0.0f;
      offset_[k] = centroids.lo[k];
      scale_[k] = usable_[k] ? scale : 0.0f;
    }
  }
  bool usable(int axis) const { return usable_[axis]; }
  int bin(float centroid, int axis) const {
    return clamp((centroid - offset_[axis]) * scale_[axis]);
  }
  std::array<int, 3> bins(const PrimRef& ref) const {
    alignas(16) float t[4];
    ((ref.centroid4() - Float4::load(offset_)) * Float4::load(scale_)).store(t);
    return {clamp(t[0]), clamp(t[1]), clamp(t[2])};
  }

 private:
  static int clamp(float t) {
    return t > 0.0f ? (t < float(bin_count - 1) ? int(t) : bin_count - 1) : 0;
  }
  alignas(16) float offset_[4]{};
  alignas(16) float scale_[4]{};
  bool usable_[3]{};
};

/// What the bins hold; merging is exact, so the order of merging does not matter.
struct BinSet {
  Box4 box[3][bin_count];
  std::uint32_t count[3][bin_count] = {};

  void add(const BinMapping& mapping, std::span<const PrimRef> refs) {
    for (const PrimRef& ref : refs) {
      const std::array<int, 3> b = mapping.bins(ref);
      const Float4 lo = ref.lo4();
      const Float4 hi = ref.hi4();
      for (int k = 0; k < 3; ++k) {
        box[k][b[k]].extend(lo, hi);
        ++count[k][b[k]];
      }
    }
  }
  void merge(const BinSet& other) {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < bin_count; ++i) {
        box[k][i].extend(other.box[k][i]);
        count[k][i] += other.count[k][i];
      }
  }
};

/// The cheapest plane between two bins, or none (`axis` < 0).
struct Split {
  int axis = -1;
  int bin = 0;                                            ///< bins below it go left
  double cost = std::numeric_limits<double>::infinity();  ///< Σ area·count of both sides
  Aabb left, right;
};

Split best_split(const BinSet& bins, const BinMapping& mapping);

}  // namespace regraft::bvh
