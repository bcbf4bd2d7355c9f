#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "regraft/bvh/box4.h"

namespace regraft::bvh {

/// A primitive while a tree is built: its box and its id in the spare lane.
struct alignas(32) PrimRef {
  float lo[3];
  std::uint32_t id;
  float hi[3];
  std::uint32_t padding;

  // The id must not reach the arithmetic: as a float it is denormal, and those are slow.
  Float4 lo4() const { return simd::REGRAFT_SIMD_NAMESPACE::load_point(lo); }
  Float4 hi4() const { return simd::REGRAFT_SIMD_NAMESPACE::load_point(hi); }
  /// Halved before they are added, so that boxes near the largest float do not overflow.
  Float4 centroid4() const { return Float4(0.5f) * lo4() + Float4(0.5f) * hi4(); }
  float centroid(int axis) const { return 0.5f * lo[axis] + 0.5f * hi[axis]; }
};

inline constexpr int max_bins = 16;

/// Maps centroids to bins on all three axes at once.
class BinMapping {
 public:
  /// `count` primitives: few need few bins, and most ranges are small.
  BinMapping(const Aabb& centroids, std::size_t count)
      : bins_(count < 4 * (max_bins - 4) ? 4 + int(count / 4) : max_bins) {
    for (int k = 0; k < 3; ++k) {
      const float extent = centroids.hi[k] - centroids.lo[k];
      const float scale = 0.999f * float(bins_) / extent;
      // Denormal or overflowing extents cannot be binned; such ranges fall back to the median.
      usable_[k] = extent > 0.0f && std::isfinite(scale) && scale > 0.0f;
      offset_[k] = centroids.lo[k];
      scale_[k] = usable_[k] ? scale : 0.0f;
    }
  }
  int count() const { return bins_; }
  bool usable(int axis) const { return usable_[axis]; }
  /// bins(ref)[axis] < bin, without rounding: bins begin at whole numbers.
  bool is_below(const PrimRef& ref, int axis, int bin) const {
    return !((ref.centroid(axis) - offset_[axis]) * scale_[axis] >= float(bin));
  }
  std::array<int, 3> bins(const PrimRef& ref) const {
    alignas(16) float t[4];
    const Float4 scaled = (ref.centroid4() - Float4::load(offset_)) * Float4::load(scale_);
    min(max(scaled, Float4(0.0f)), Float4(float(bins_ - 1))).store(t);
    return {int(t[0]), int(t[1]), int(t[2])};
  }

 private:
  alignas(16) float offset_[4]{};
  alignas(16) float scale_[4]{};
  bool usable_[3]{};
  int bins_;
};

/// What the bins hold; merging is exact, so the order of merging does not matter.
struct BinSet {
  /// Boxes of bins beyond `used` are not touched, not even to empty them.
  explicit BinSet(int used) : used_(used) {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < used; ++i) {
        box[k][i].lo = Float4(std::numeric_limits<float>::infinity());
        box[k][i].hi = Float4(-std::numeric_limits<float>::infinity());
      }
  }
  struct Bounds {
    Float4 lo, hi;
  };
  Bounds box[3][max_bins];
  std::uint32_t count[3][max_bins] = {};

  /// Both halves in turns: neighbours often fall into one bin, and would wait for each other.
  void add(const BinMapping& mapping, std::span<const PrimRef> refs) {
    const std::size_t half = refs.size() / 2;
    for (std::size_t i = 0; i < half; ++i) {
      add(mapping, refs[i]);
      add(mapping, refs[half + i]);
    }
    if (refs.size() % 2 != 0) add(mapping, refs.back());
  }
  void add(const BinMapping& mapping, const PrimRef& ref) {
    const std::array<int, 3> b = mapping.bins(ref);
    const Float4 lo = ref.lo4();
    const Float4 hi = ref.hi4();
    for (int k = 0; k < 3; ++k) {
      Bounds& bounds = box[k][b[k]];
      bounds.lo = min(lo, bounds.lo);
      bounds.hi = max(hi, bounds.hi);
      ++count[k][b[k]];
    }
  }
  /// How many are in the bins before `bin` on an axis.
  std::uint32_t count_below(int axis, int bin) const {
    std::uint32_t sum = 0;
    for (int i = 0; i < bin; ++i) sum += count[axis][i];
    return sum;
  }
  /// Box of the bins from `begin` to before `end` on an axis.
  Box4 bounds(int axis, int begin, int end) const {
    Box4 all;
    for (int i = begin; i < end; ++i) all.extend(box[axis][i].lo, box[axis][i].hi);
    return all;
  }
  void merge(const BinSet& other) {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < used_; ++i) {
        box[k][i].lo = min(other.box[k][i].lo, box[k][i].lo);
        box[k][i].hi = max(other.box[k][i].hi, box[k][i].hi);
        count[k][i] += other.count[k][i];
      }
  }

 private:
  int used_;
};

/// The cheapest plane between two bins, or none (`axis` < 0).
struct Split {
  int axis = -1;
  int bin = 0;                                            ///< bins below it go left
  double cost = std::numeric_limits<double>::infinity();  ///< Σ area·count of both sides
};

/// The best split of `size` primitives in bins.
Split best_split(const BinSet& bins, const BinMapping& mapping, std::uint32_t size);

}  // namespace regraft::bvh
