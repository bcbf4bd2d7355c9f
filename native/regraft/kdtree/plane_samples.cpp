#include "regraft/kdtree/plane_samples.h"

#include <algorithm>
#include <bit>

namespace regraft::kdtree {
namespace {

double counted(double weight) {
  return weight > 0.0 ? weight : 0.0;
}

/// Least j such that the multiples of 2^-j include i/count.
int level_of(int i, int count) {
  return std::countr_zero(unsigned(count)) - std::countr_zero(unsigned(i));
}

}  // namespace

UniformSamples::UniformSamples(std::span<const SplitEntry> entries, const Aabb& voxel, int bins)
    : voxel_(voxel), bins_(voxel, bins) {
  for (Weights& axis : weights_) {
    std::fill_n(axis.lo.begin(), bins + 2, 0.0);
    std::fill_n(axis.hi.begin(), bins + 2, 0.0);
  }
  for (const SplitEntry& entry : entries) {
    const EventBins::Index index = bins_.index(entry);
    const double weight = counted(entry.weight);
    for (std::size_t k = 0; k < 3; ++k) {
      weights_[k].lo[std::size_t(index.lo[k])] += weight;
      weights_[k].hi[std::size_t(index.hi[k])] += weight;
    }
  }
  for (Weights& axis : weights_)
    for (int i = 1; i < bins + 2; ++i) {
      axis.lo[std::size_t(i)] += axis.lo[std::size_t(i - 1)];
      axis.hi[std::size_t(bins + 1 - i)] += axis.hi[std::size_t(bins + 2 - i)];
    }
}

PlaneSample UniformSamples::plane(int axis, int i) const {
  const double lo = voxel_.lo[axis];
  const double hi = voxel_.hi[axis];
  const int count = bins_.count();
  const Weights& weights = weights_[std::size_t(axis)];
  const double position = i == count ? hi : lo + (hi - lo) * i / count;
  return {position, weights.lo[std::size_t(i)], weights.hi[std::size_t(i + 1)],
          i == 0 || i == count ? 0 : level_of(i, count)};
}

double UniformSamples::rise(int axis, int i) const {
  const Weights& weights = weights_[std::size_t(axis)];
  const std::size_t bin = std::size_t(i);
  return weights.lo[bin] - weights.lo[bin - 1] + weights.hi[bin] - weights.hi[bin + 1];
}

AxisSamples UniformSamples::samples(int axis) const {
  AxisSamples result;
  for (int i = 0; i <= bins_.count(); ++i) result.add(plane(axis, i));
  return result;
}

QuantileSamples::QuantileSamples(std::span<const SplitEntry> entries, const UniformSamples& uniform,
                                 int level)
    : uniform_(uniform), level_(level) {
  for (int axis = 0; axis < 3; ++axis) place(axis);
  for (const SplitEntry& entry : entries) {
    const EventBins::Index index = uniform.bins().index(entry);
    const double weight = counted(entry.weight);
    for (int k = 0; k < 3; ++k) {
      Axis& axis = axes_[std::size_t(k)];
      axis.lo[std::size_t(between(axis, index.lo[std::size_t(k)], entry.box.lo[k]))] += weight;
      axis.hi[std::size_t(between(axis, index.hi[std::size_t(k)], entry.box.hi[k]))] += weight;
    }
  }
}

void QuantileSamples::place(int k) {
  Axis& axis = axes_[std::size_t(k)];
  const int bins = uniform_.bins().count();
  const int planes = (1 << level_) - 1;
  std::fill_n(axis.lo.begin(), planes + 1, 0.0);
  std::fill_n(axis.hi.begin(), planes + 1, 0.0);
  double total = 0.0;
  for (int i = 1; i <= bins; ++i) total += uniform_.rise(k, i);
  const double step = total / (planes + 1);
  axis.rows.front() = {0.0, 0.0, 0.0, 0};
  double below = 0.0;
  int placed = 0;
  for (int i = 1; i <= bins; ++i) {
    const double rise = uniform_.rise(k, i);
    const double lo = uniform_.plane(k, i - 1).position;
    const double width = uniform_.plane(k, i).position - lo;
    const int before = placed;
    while (rise > 0.0 && width > 0.0 && placed < planes && (placed + 1) * step <= below + rise)
      ++placed;
    Row& row = axis.rows[std::size_t(i)];
    row = {0.0, 0.0, double(placed - before), before};
    if (placed > before) {
      row.first = lo + width * ((before + 1) * step - below) / rise;
      row.density = rise / (width * step);
    }
    below += rise;
  }
  axis.rows[std::size_t(bins + 1)] = {0.0, 0.0, 0.0, placed};
}

int QuantileSamples::between(const Axis& axis, int bin, float position) const {
  const Row& row = axis.rows[std::size_t(bin)];
  double t = (double(position) - row.first) * row.density + 1.0;
  t = t < row.count ? t : row.count;
  return row.before + int(t > 0.0 ? t : 0.0);
}

AxisSamples QuantileSamples::samples(int k) const {
  const Axis& axis = axes_[std::size_t(k)];
  const int bins = uniform_.bins().count();
  const int planes = 1 << level_;
  AxisSamples result;
  result.add(uniform_.plane(k, 0));
  double left = 0.0;
  double right = 0.0;
  for (int q = 0; q < planes; ++q) right += axis.hi[std::size_t(q)];
  int placed = 0;
  for (int i = 1; i <= bins; ++i) {
    const Row& row = axis.rows[std::size_t(i)];
    for (int j = 0; j < int(row.count); ++j, ++placed) {
      left += axis.lo[std::size_t(placed)];
      right -= axis.hi[std::size_t(placed)];
      const double position = row.first + (j > 0 ? j / row.density : 0.0);
      result.add({position, left, right, level_of(placed + 1, planes)});
    }
    const PlaneSample above = uniform_.plane(k, i);
    if (above.level <= level_) result.add(above);
  }
  return result;
}

}  // namespace regraft::kdtree
