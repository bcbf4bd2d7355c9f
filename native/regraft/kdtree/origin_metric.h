#pragma once

#include "regraft/kdtree/origin_space.h"

namespace regraft::kdtree {

/// How the probability p_N that a ray visits a box N is computed. All but `sah` suppose that the
/// ray's origin is uniform in a box S and its direction uniform: Fabianowski, Fowler, Dingliana,
/// A cost metric for scene-interior ray origins, Eurographics 2009 (short papers).
enum class OriginMetric {
  sah,        ///< eq. 2: ratio of areas, origins infinitely far away
  regions6,   ///< eq. 5 with eq. 10: six slabs, a handful of operations
  regions26,  ///< eq. 4: solid angles from the centres of 26 regions; the paper's reference
  faces,      ///< the exact integral over S for the centre of each face of N
  exact,      ///< eq. 3 in closed form
};

/// p_N in [0, 1]. N is clipped to S. Falls back to `sah` where S has no volume. 0 if N misses S.
double visit_probability(OriginMetric metric, const Aabb& origins, const Aabb& box);
/// The same where S is known to have a volume and the metric is not `sah`.
double visit_probability(OriginMetric metric, const OriginSpace& space);

}  // namespace regraft::kdtree
