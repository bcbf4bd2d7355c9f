#pragma once

#include <cstdint>
#include <limits>

#include "regraft/core/vec.h"
#include "regraft/trace/trace_view.h"

namespace regraft::trace {

/// The nearest point of the scene's surfaces. Nothing within reach: `distance` = inf, ids =
/// `invalid_id`.
struct PointHit {
  double distance = std::numeric_limits<double>::infinity();  ///< metres, world frame
  Vec3d point{0.0};                                           ///< world frame
  std::uint32_t instance_id = invalid_id;
  std::uint32_t prim_id = invalid_id;
  /// Weights of the triangle's second and third vertex.
  float u = 0.0f;
  float v = 0.0f;
};

/// Nearest point to `p` within `max_distance`. Among equally near triangles the lowest (instance,
/// prim) counts. A distance is defined by (p, instance, triangle) alone, in double: trees only
/// leave out what is farther, so every layout and policy gives the same bits.
///
/// Works for any placement: boxes are measured in object space, where distances are at least the
/// world's divided by the transform's largest stretch.
PointHit closest_point(const TraceView& view, const Vec3d& p, double max_distance);

/// The same by looking at every triangle.
PointHit closest_point_brute_force(const TraceView& view, const Vec3d& p, double max_distance);

}  // namespace regraft::trace
