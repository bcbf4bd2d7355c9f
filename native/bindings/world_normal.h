#pragma once

#include "regraft/scene/scene.h"

namespace regraft::bindings {

/// Geometric unit normal of a placed triangle, world frame, facing as the placed triangle is
/// wound; zero for one without area.
Vec3 world_normal(const Scene& scene, std::uint32_t instance_id, std::uint32_t prim_id);

}  // namespace regraft::bindings
