#pragma once

#include <array>
#include <span>
#include <vector>

#include "regraft/core/aabb.h"

namespace regraft::bvh {

/// A plane across one axis.
struct Plane {
  int axis = 0;
  double position = 0.0;
};

/// Numbers of boxes on two sides, ascending.
using Sides = std::array<std::vector<std::uint32_t>, 2>;

/// The first `first` of `count` and the rest.
Sides as_they_are(std::size_t count, std::size_t first);

/// Shares boxes out to two sides, neither empty if there are two boxes at least: as they are (the
/// first `first` and the rest), by centre below or above `plane`, or by the best of binned planes
/// (surface area heuristic), whichever is cheapest to trace by area times number. If all are one
/// sided, in the middle by (centre, number). The lower boxes along the plane's axis go left.
Sides share_out(std::span<const Aabb> boxes, std::size_t first, const Plane& plane);

}  // namespace regraft::bvh
