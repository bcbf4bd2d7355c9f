#pragma once

#include <pybind11/pybind11.h>

#include "scene_handle.h"

namespace regraft::bindings {

using SceneClass = pybind11::class_<SceneHandle>;

/// Each adds its part of the module; together they are docs/api.md. Classes come first: the
/// signatures that pybind11 writes name only what exists already.
void bind_statistics(pybind11::module_& module);
void bind_results(pybind11::module_& module);
void bind_point_results(pybind11::module_& module);
void bind_machine(pybind11::module_& module);
void bind_node_results(pybind11::module_& module);
void bind_frame(pybind11::module_& module);
void bind_scene(SceneClass& scene);
void bind_instances(SceneClass& scene);
void bind_update(SceneClass& scene);
void bind_queries(SceneClass& scene);
void bind_points(SceneClass& scene);
void bind_key_frames(SceneClass& scene);
void bind_nodes(SceneClass& scene);
void bind_render(SceneClass& scene);
void bind_kdtree(pybind11::module_& module);

}  // namespace regraft::bindings
