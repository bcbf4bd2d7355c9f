#pragma once

#include <array>
#include <cstring>

#include "regraft/kdtree/split.h"

namespace regraft::kdtree {

/// Sorts the bounds of entries into equal bins along all three axes at once. Bin 0 holds what is
/// at or below the lower face of the voxel, 1 to `count` what is inside, `count` + 1 what is at
/// or above the upper face. The arithmetic is monotone: what is in a lower bin lies lower.
///
/// Four lanes are the compiler's own vectors: the best instructions of every target without
/// intrinsics. Half the time of the same loop in scalars.
class EventBins {
 public:
  static constexpr int max_count = 64;
  /// By axis; the last lane is of no use.
  using Lanes = std::array<int, 4>;
  struct Index {
    Lanes lo, hi;
  };

  EventBins(const Aabb& voxel, int count);
  /// Whether the extents are such that the arithmetic neither overflows nor underflows.
  static bool usable(const Aabb& voxel);

  int count() const { return count_; }
  Index index(const SplitEntry& entry) const {
    static_assert(sizeof(SplitEntry) == 32 && sizeof(Aabb) == 24);
    const char* const bytes = reinterpret_cast<const char*>(&entry);
    Floats lo;
    Floats hi;
    std::memcpy(&lo, bytes, sizeof lo);
    std::memcpy(&hi, bytes + sizeof(Aabb) - sizeof hi, sizeof hi);
    return {bins(lo), bins(__builtin_shufflevector(hi, hi, 1, 2, 3, 3))};
  }

 private:
  using Floats [[gnu::vector_size(16)]] = float;
  using Ints [[gnu::vector_size(16)]] = int;

  Lanes bins(Floats x) const {
    Floats t = (x - zero_) * scale_;
    t = t < last_ ? t : last_;
    t = t > Floats{} ? t : Floats{};
    // A comparison that holds is -1.
    const Ints bin = __builtin_convertvector(t, Ints) - (x > zero_) - (x >= end_);
    Lanes lanes;
    std::memcpy(&lanes, &bin, sizeof lanes);
    return lanes;
  }

  Floats zero_{};
  Floats end_{};
  Floats scale_{};
  Floats last_{};
  int count_;
};

}  // namespace regraft::kdtree
