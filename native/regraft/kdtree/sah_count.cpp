#include "regraft/kdtree/sah_count.h"

#include <array>
#include <cstring>

namespace regraft::kdtree {
namespace {

constexpr double largest_sum = 0x1p24;

/// Four lanes, as in EventBins.
using Floats [[gnu::vector_size(16)]] = float;
using Ints [[gnu::vector_size(16)]] = int;

Floats where(Ints mask, Floats value) {
  return Floats(mask & Ints(value));
}

/// The entries along one axis, and the planes to weigh.
class Counting {
 public:
  Counting(std::span<const SplitEntry> entries, const Aabb& voxel, int axis) {
    for (const SplitEntry& entry : entries) {
      if (!(entry.weight > 0.0)) continue;
      const float lo = entry.box.lo[axis];
      const float hi = entry.box.hi[axis];
      lo_[entries_] = lo;
      hi_[entries_] = hi;
      weight_[entries_++] = float(entry.weight);
      unit_ &= entry.weight == 1.0;
      any_flat_ |= lo == hi;
      position_[planes_] = lo;
      planes_ += lo > voxel.lo[axis] && lo < voxel.hi[axis];
      position_[planes_] = hi;
      planes_ += hi > voxel.lo[axis] && hi < voxel.hi[axis] && hi != lo;
    }
    for (std::size_t i = planes_; i % 4 != 0; ++i) position_[i] = 0.0f;
  }

  std::size_t planes() const { return planes_; }
  float position(std::size_t i) const { return position_[i]; }
  Sides sides(std::size_t i) const { return {left_[i], right_[i], any_flat_ ? flat_[i] : 0.0f}; }

  void count() {
    if (any_flat_ || !unit_)
      count_weights();
    else
      count_units();
  }

 private:
  void count_weights() {
    for (std::size_t p = 0; p < planes_; p += 4) {
      const Floats x = load(&position_[p]);
      Floats left{}, right{}, flat{};
      for (std::size_t i = 0; i < entries_; ++i) {
        const Floats weight = weight_[i] - Floats{};
        left += where(lo_[i] < x, weight);
        right += where(hi_[i] > x, weight);
        flat += where((lo_[i] == x) & (hi_[i] == x), weight);
      }
      std::memcpy(&left_[p], &left, sizeof left);
      std::memcpy(&right_[p], &right, sizeof right);
      std::memcpy(&flat_[p], &flat, sizeof flat);
    }
  }

  /// Most lists: nothing but primitives. A comparison that holds is -1.
  void count_units() {
    for (std::size_t p = 0; p < planes_; p += 4) {
      const Floats x = load(&position_[p]);
      Ints left{}, right{};
      for (std::size_t i = 0; i < entries_; ++i) {
        left -= lo_[i] < x;
        right -= hi_[i] > x;
      }
      const Floats lefts = __builtin_convertvector(left, Floats);
      const Floats rights = __builtin_convertvector(right, Floats);
      std::memcpy(&left_[p], &lefts, sizeof lefts);
      std::memcpy(&right_[p], &rights, sizeof rights);
    }
  }

  static Floats load(const float* from) {
    Floats x;
    std::memcpy(&x, from, sizeof x);
    return x;
  }

  template <std::size_t n>
  using Array = std::array<float, n>;
  // Not initialised: few are used.
  Array<most_counted> lo_, hi_, weight_;
  Array<2 * most_counted + 4> position_, left_, right_, flat_;
  std::size_t entries_ = 0;
  std::size_t planes_ = 0;
  bool any_flat_ = false;
  bool unit_ = true;
};

}  // namespace

bool countable(std::span<const SplitEntry> entries) {
  double sum = 0.0;
  bool whole = true;
  for (const SplitEntry& entry : entries) {
    const double weight = entry.weight > 0.0 ? entry.weight : 0.0;
    sum += weight;
    whole &= weight <= largest_sum && weight == double(int(weight <= largest_sum ? weight : 0.0));
  }
  return whole && sum <= largest_sum && entries.size() <= most_counted;
}

Split count_split(std::span<const SplitEntry> entries, const ChildProbability& probability,
                  const SplitCost& cost) {
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    Counting counting(entries, probability.voxel(), axis);
    counting.count();
    double costs[2 * most_counted];
    for (std::size_t i = 0; i < counting.planes(); ++i)
      costs[i] = plane_cost(cost, probability.at(axis, counting.position(i)), counting.sides(i));
    for (std::size_t i = 0; i < counting.planes(); ++i) {
      if (costs[i] > best.cost) continue;
      const float x = counting.position(i);
      const ChildProbability::Pair p = probability.at(axis, x);
      offer(best, axis, x, costs[i], p.left < p.right);
    }
    best.samples += std::uint32_t(counting.planes());
  }
  best.lower_bound = best.cost;
  return best;
}

}  // namespace regraft::kdtree
