#pragma once

#include <array>
#include <span>

#include "regraft/kdtree/event_bins.h"
#include "regraft/kdtree/split_event.h"

namespace regraft::kdtree {

/// A plane between two neighbouring floats, where no bound of an entry can lie. The weights are
/// exact; the position is so up to rounding, 1e-6 of the voxel's extent at most.
struct PlaneSample {
  double position;
  double left;   ///< weight of entries with lo below
  double right;  ///< weight of entries with hi above
  int level;     ///< least j such that 2^j − 1 samples include this one
};

/// The planes sampled across one axis, in order; the first and the last are the voxel's faces.
class AxisSamples {
 public:
  void add(const PlaneSample& sample) { samples_[std::size_t(count_++)] = sample; }
  std::span<const PlaneSample> all() const { return {samples_.data(), std::size_t(count_)}; }

 private:
  std::array<PlaneSample, 2 * EventBins::max_count> samples_;  // not initialised: few are used
  int count_ = 0;
};

/// Planes at equal distances: one pass over the entries.
class UniformSamples {
 public:
  /// `bins`: a power of two, at most `EventBins::max_count`.
  UniformSamples(std::span<const SplitEntry> entries, const Aabb& voxel, int bins);

  const EventBins& bins() const { return bins_; }
  /// The plane above bin `i`; 0 is the lower face of the voxel, `bins` the upper.
  PlaneSample plane(int axis, int i) const;
  /// Weight of the bounds in bin `i`, by which N_left − N_right rises across it.
  double rise(int axis, int i) const;
  AxisSamples samples(int axis) const;

 private:
  struct Weights {
    std::array<double, EventBins::max_count + 2> lo;  ///< in this bin or below
    std::array<double, EventBins::max_count + 2> hi;  ///< in this bin or above
  };
  Aabb voxel_;
  EventBins bins_;
  std::array<Weights, 3> weights_;
};

/// Planes at equal increments of N_left − N_right, taken as linear between the uniform ones, so
/// that crowded places get more: another pass over the entries. Merged with uniform ones.
class QuantileSamples {
 public:
  /// 2^`level` − 1 of either kind on each axis.
  QuantileSamples(std::span<const SplitEntry> entries, const UniformSamples& uniform, int level);
  AxisSamples samples(int axis) const;

 private:
  /// The planes inside one uniform bin: equally spaced.
  struct Row {
    double first;    ///< position of the first
    double density;  ///< planes per length
    double count;
    int before;  ///< planes in lower bins
  };
  struct Axis {
    std::array<Row, EventBins::max_count + 2> rows;
    std::array<double, EventBins::max_count> lo, hi;  ///< weights between the planes
  };
  void place(int axis);
  int between(const Axis& axis, int bin, float position) const;

  const UniformSamples& uniform_;
  int level_;
  std::array<Axis, 3> axes_;
};

}  // namespace regraft::kdtree
