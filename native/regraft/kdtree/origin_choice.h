#pragma once

#include <span>

#include "regraft/kdtree/origin_metric.h"

namespace regraft::kdtree {

/// By which metric to split, and the box of ray origins it supposes.
struct OriginChoice {
  OriginMetric metric = OriginMetric::sah;
  Aabb origins;
};

/// `auto`: p_N pays only where rays start inside the scene; with the light outside, Fabianowski
/// et al. 2009 lose 3.8 %. `pilot`: origins of a sample of the rays to come, one in a hundred will
/// do. Of a ray to a light, the light: such a ray may be taken from either end, and if one lies
/// outside it is not of the kind that the metric supposes. A light at infinity is not finite.
///
/// The origins' box is that of nearly all of the pilot, clipped to the scene: a few on a sky or
/// on far ground do not stretch it. `regions6` if it has a volume, holds the camera and most of
/// the pilot, else `sah`. O(n).
OriginChoice choose_origin_metric(std::span<const Vec3> pilot, const Aabb& scene,
                                  const Vec3& camera);

}  // namespace regraft::kdtree
