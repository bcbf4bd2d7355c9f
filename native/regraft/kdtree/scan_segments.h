#pragma once

#include "regraft/kdtree/plane_samples.h"

namespace regraft::kdtree {

/// A sample plane with its chances: what costs and bounds are made of.
struct CostedSample {
  CostedSample(const SplitProblem& problem, int axis, const PlaneSample& sample)
      : plane(sample), p(problem.probability.at(axis, sample.position)) {}
  double cost(const SplitProblem& problem) const {
    return plane_cost(problem.cost, p, {plane.left, plane.right, 0.0});
  }
  /// No bound of an entry lies between this sample and the next.
  bool nothing_until(const CostedSample& next) const {
    return plane.left == next.plane.left && plane.right == next.plane.right;
  }

  PlaneSample plane;
  ChildProbability::Pair p;
};

/// The planes between two neighbouring samples of one axis.
struct ScanSegment {
  double bound;  ///< no plane in it costs less
  PlaneSample from, to;
  int axis;
  int index;            ///< among the segments of its axis
  std::uint32_t first;  ///< of its events, once they are collected
  std::uint32_t count;
};

/// No plane between two samples costs less: N_left is at least that of the lower sample, N_right
/// that of the upper, and the probabilities are monotone; where they are linear, the sum is least
/// at an end. A little is taken off, since positions of samples are rounded.
double segment_bound(const SplitProblem& problem, const CostedSample& from, const CostedSample& to);

}  // namespace regraft::kdtree
