#pragma once

#include <string>

#include "regraft/accel/update_policy.h"
#include "regraft/scene/scene.h"

namespace regraft::accel {

/// What `structure="auto"` chose.
struct StructureChoice {
  Structure structure = Structure::bvh;
  std::string reason;
};

/// A k-d tree that builds itself where rays go wins where most of a scene would be read for
/// nothing: a single frame (`frames_left` = 1) of many triangles few of which are in view. A tree
/// that exists is kept: `present` is what is traced now, if anything.
StructureChoice choose_structure(const Scene& scene, const UpdateOptions& options,
                                 Structure present);

/// Share of the scene's triangles that the camera has in its window, estimated at vertices spread
/// over all meshes; O(instances).
double share_in_view(const Scene& scene, const Camera& camera);

}  // namespace regraft::accel
