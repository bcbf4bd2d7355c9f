#pragma once

#include <span>
#include <vector>

#include "regraft/accel/instance_set.h"
#include "regraft/core/aabb.h"
#include "regraft/core/executor.h"
#include "regraft/scene/change_set.h"
#include "regraft/scene/scene.h"

namespace regraft::accel {

/// Boxes of primitives by key frame of the shot; none: no key frames are known.
using KeyBoxes = std::vector<std::vector<Aabb>>;

/// Of a mesh's triangles, in its own frame.
KeyBoxes key_boxes(const Mesh& mesh, Executor& executor);

/// Of the top tree's primitives: instances, or the triangles in `flat`. What has no key frames of
/// its own stays where it is; what has fewer than others keeps its last.
KeyBoxes key_boxes(const Scene& scene, const InstanceSet& instances,
                   std::span<const trace::FlatPrim> flat, Executor& executor);

/// Throws std::invalid_argument if a mesh has deformed, or an instance moved, whose key frames
/// nobody gave: no tree can be planned for the whole shot then.
void require_key_frames(const Scene& scene, const ChangeSet& changes);

}  // namespace regraft::accel
