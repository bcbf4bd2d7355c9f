#include "regraft/kdtree/child_probability.h"

#include <cmath>

namespace regraft::kdtree {

ChildProbability::ChildProbability(const Aabb& voxel) : voxel_(voxel) {
  prepare_sah();
}

ChildProbability::ChildProbability(const Aabb& voxel, OriginMetric metric, const Aabb& origins)
    : voxel_(voxel), metric_(metric) {
  if (metric != OriginMetric::sah) {
    space_ = OriginSpace(origins, voxel);
    visit_ = space_.volume() > 0.0 ? visit_probability(metric, space_) : 0.0;
    if (!(visit_ > 0.0)) metric_ = OriginMetric::sah;
  }
  if (metric_ == OriginMetric::sah) prepare_sah();
  if (metric_ == OriginMetric::regions6) prepare_regions6();
}

ChildProbability::Pair ChildProbability::origins_at(int axis, double position) const {
  const double place = space_.place(axis, position);
  if (place < 0.0) return {0.0, 1.0};
  if (place > space_.size[axis]) return {1.0, 0.0};
  return metric_ == OriginMetric::regions6 ? regions6_at(axis, place) : general_at(axis, place);
}

void ChildProbability::prepare_sah() {
  const Vec3d e = voxel_.extents();
  const double area = half_area(voxel_);
  const double length = e.x + e.y + e.z;
  for (int k = 0; k < 3; ++k) {
    const double u = e[(k + 1) % 3];
    const double v = e[(k + 2) % 3];
    Terms& t = terms_[std::size_t(k)];
    // A voxel without area is a line: lengths take the place of areas (core/aabb.h).
    t.slope = area > 0.0 ? (u + v) / area : (length > 0.0 ? 1.0 / length : 0.0);
    t.base_left = t.base_right =
        area > 0.0 ? u * v / area : (length > 0.0 ? (u + v) / length : 1.0);
  }
}

void ChildProbability::prepare_regions6() {
  const double scale = 1.0 / (visit_ * space_.volume());
  std::array<double, 3> both{};  // m below plus m above
  for (int k = 0; k < 3; ++k)
    both[std::size_t(k)] =
        space_.slab_weight(k, space_.gap_below(k)) + space_.slab_weight(k, space_.gap_above(k));
  const Vec3d e = space_.hi - space_.lo;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3;
    const int j = (k + 2) % 3;
    Terms& t = terms_[std::size_t(k)];
    t.face = e[i] * e[j] * scale;
    t.slope = t.face + (e[i] * both[std::size_t(j)] + e[j] * both[std::size_t(i)]) * scale;
    t.base_left = t.face * space_.slab_weight(k, space_.gap_below(k));
    t.base_right = t.face * space_.slab_weight(k, space_.gap_above(k));
  }
}

ChildProbability::Pair ChildProbability::regions6_at(int axis, double place) const {
  const Terms& t = terms_[std::size_t(axis)];
  return {t.base_left + t.slope * (place - space_.lo[axis]) +
              t.face * space_.slab_weight(axis, space_.size[axis] - place),
          t.base_right + t.slope * (space_.hi[axis] - place) +
              t.face * space_.slab_weight(axis, place)};
}

ChildProbability::Pair ChildProbability::general_at(int axis, double place) const {
  OriginSpace left = space_;
  OriginSpace right = space_;
  left.hi[axis] = std::min(place, space_.hi[axis]);
  right.lo[axis] = std::max(place, space_.lo[axis]);
  return {visit_probability(metric_, left) / visit_, visit_probability(metric_, right) / visit_};
}

}  // namespace regraft::kdtree
