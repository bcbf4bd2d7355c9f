#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "regraft/core/vec.h"

namespace regraft {

/// A mesh placed in the world. `mesh`, `group` and `material_list` as given by `Scene`; `alive` is
/// set there.
struct Instance {
  std::string name;
  Mat4d object_to_world{1.0};
  std::uint32_t mesh = invalid_id;
  std::uint32_t group = invalid_id;
  /// From `Scene::material_list`: the materials of the mesh's slots.
  std::uint32_t material_list = 0;
  std::uint32_t object_index = 0;
  /// Matrices in key frames of the shot, if the host has told.
  std::vector<Mat4d> key_transforms;
  bool visible = true;
  bool alive = false;
};

/// `instance 3 "Wheel"`, as error messages call it.
std::string label(const Instance& instance, std::uint32_t id);

/// A level of the scene's hierarchy; carries no transform.
struct Group {
  std::string name;
  std::uint32_t parent = invalid_id;
};

}  // namespace regraft
