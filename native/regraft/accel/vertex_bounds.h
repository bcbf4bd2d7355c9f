#pragma once

#include <optional>
#include <span>

#include "regraft/core/aabb.h"
#include "regraft/core/executor.h"

namespace regraft::accel {

/// Box of points; none if one of them is not finite.
std::optional<Aabb> vertex_bounds(std::span<const Vec3> vertices, Executor& executor);

}  // namespace regraft::accel
