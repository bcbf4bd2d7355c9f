#pragma once

#include <array>

#include "regraft/kdtree/origin_metric.h"

namespace regraft::kdtree {

/// Probability that a ray which visits a voxel visits its left or right child, for any plane.
/// It never falls as the child grows, which error bounds rely on: proven for `sah`, `regions6`
/// and `exact`; no counterexample known for the two others.
class ChildProbability {
 public:
  struct Pair {
    double left;
    double right;
  };

  /// Surface area heuristic.
  explicit ChildProbability(const Aabb& voxel);
  /// Origins in the box `origins`. Falls back to the surface area heuristic where that box has
  /// no volume and where the metric sees no ray visit the voxel.
  ChildProbability(const Aabb& voxel, OriginMetric metric, const Aabb& origins);

  /// `position` lies in the voxel. `sah`, `regions6`: a handful of operations; else two p_N.
  Pair at(int axis, double position) const {
    return metric_ == OriginMetric::sah ? sah_at(axis, position) : origins_at(axis, position);
  }
  /// Both are linear in the position: bounds are tighter then.
  bool linear() const { return metric_ == OriginMetric::sah; }
  const Aabb& voxel() const { return voxel_; }

 private:
  /// p(child) = base + slope·thickness + face·m(gap between the plane and S), over p(voxel).
  struct Terms {
    double slope = 0.0;
    double face = 0.0;
    double base_left = 0.0;
    double base_right = 0.0;
  };
  void prepare_sah();
  void prepare_regions6();
  Pair sah_at(int axis, double position) const {
    const Terms& t = terms_[std::size_t(axis)];
    return {t.base_left + t.slope * (position - double(voxel_.lo[axis])),
            t.base_right + t.slope * (double(voxel_.hi[axis]) - position)};
  }
  Pair origins_at(int axis, double position) const;
  Pair regions6_at(int axis, double place) const;
  Pair general_at(int axis, double place) const;

  Aabb voxel_;
  OriginMetric metric_ = OriginMetric::sah;
  double visit_ = 1.0;  ///< p_N of the voxel
  std::array<Terms, 3> terms_;
  OriginSpace space_;
};

}  // namespace regraft::kdtree
