#pragma once

#include "args.h"
#include "regraft/scene/camera.h"
#include "regraft/scene/light.h"

namespace regraft::bindings {

using CameraArg = Arg<"regraft.camera.Camera">;
using LightsArg = Arg<"collections.abc.Sequence[regraft.light.Light]">;

/// Reads a `regraft.Camera`, or whatever has its attributes. ValueError naming the attribute that
/// is missing or wrong.
Camera read_camera(const py::object& camera);

/// Reads a sequence of `regraft.Light`, or of what has its attributes.
std::vector<Light> read_lights(const py::object& lights);

}  // namespace regraft::bindings
