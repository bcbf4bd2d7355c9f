#pragma once

#include <bit>
#include <limits>
#include <span>

#include "regraft/bvh/binning.h"

namespace regraft::bvh {

/// The best of all ways to part two to four primitives: fewer areas than a sweep of bins takes, and
/// more choices.
struct FewParted {
  static constexpr std::uint32_t most = 4;

  /// Bit i: primitive i goes left. Primitive 0 does, also where no cost is a number.
  std::uint32_t left = 1;
  double cost = std::numeric_limits<double>::infinity();  ///< Σ area·count of both sides
  Box4 left_box, right_box;

  explicit FewParted(std::span<const PrimRef> refs) {
    const std::uint32_t all = (1u << refs.size()) - 1;
    Box4 box[1u << most];
    double area[1u << most];
    for (std::uint32_t set = 1; set < all; ++set) {
      const PrimRef& ref = refs[std::size_t(std::countr_zero(set))];
      box[set] = box[set & (set - 1)];
      box[set].extend(ref.lo4(), ref.hi4());
      area[set] = box[set].half_area() * std::popcount(set);
    }
    for (std::uint32_t set = 1; set < all; set += 2) {
      const double both = area[set] + area[all ^ set];
      if (!(both < cost)) continue;
      cost = both;
      left = set;
    }
    left_box = box[left];
    right_box = box[all ^ left];
  }
};

}  // namespace regraft::bvh
