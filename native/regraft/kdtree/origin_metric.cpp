#include "regraft/kdtree/origin_metric.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "regraft/kdtree/origin_integral.h"
#include "regraft/kdtree/origin_space.h"
#include "regraft/kdtree/solid_angle.h"

namespace regraft::kdtree {
namespace {

/// Eq. 5: rays from the slab between a face of N and S hit that face as if the slab's other
/// bounds did not matter, m(t)·area of the face (eq. 10).
double regions6(const OriginSpace& s) {
  double sum = s.box_volume();
  for (int k = 0; k < 3; ++k)
    sum += s.face_area(k) * (s.slab_weight(k, s.gap_below(k)) + s.slab_weight(k, s.gap_above(k)));
  return sum / s.volume();
}

/// Eq. 4: the planes of N part S into 27 boxes; each is represented by its centre.
double regions26(const OriginSpace& s) {
  const auto cut = [&s](int k, int i) {
    const std::array<double, 4> cuts{0.0, s.lo[k], s.hi[k], s.size[k]};
    return cuts[std::size_t(i)];
  };
  double sum = 0.0;
  for (int region = 0; region < 27; ++region) {
    const std::array<int, 3> at{region % 3, region / 3 % 3, region / 9};
    Vec3d centre(0.0);
    double volume = 1.0;
    for (int k = 0; k < 3; ++k) {
      const double lo = cut(k, at[std::size_t(k)]);
      const double hi = cut(k, at[std::size_t(k)] + 1);
      centre[k] = 0.5 * (lo + hi);
      volume *= hi - lo;
    }
    const bool inside = region == 13;
    if (volume > 0.0)
      sum +=
          inside ? volume : volume * box_solid_angle(s.lo, s.hi, centre) / (4.0 * std::numbers::pi);
  }
  return sum / s.volume();
}

}  // namespace

double visit_probability(OriginMetric metric, const OriginSpace& space) {
  if (space.misses()) return 0.0;
  double p = 0.0;
  switch (metric) {
    case OriginMetric::regions6:
      p = regions6(space);
      break;
    case OriginMetric::regions26:
      p = regions26(space);
      break;
    case OriginMetric::faces:
      p = face_probability(space, 1);
      break;
    default:
      p = exact_probability(space);
      break;
  }
  return std::clamp(p, 0.0, 1.0);
}

double visit_probability(OriginMetric metric, const Aabb& origins, const Aabb& box) {
  const OriginSpace space(origins, box);
  if (metric == OriginMetric::sah || !(space.volume() > 0.0))
    return hit_probability(clipped(box, origins), origins);
  return visit_probability(metric, space);
}

}  // namespace regraft::kdtree
