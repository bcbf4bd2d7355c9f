#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "regraft/scene/scene.h"

namespace regraft::test {

/// A unit square of two triangles, owning what `MeshData` points at.
struct Square {
  std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<Triangle> triangles{{0, 1, 2}, {0, 2, 3}};
  std::vector<std::uint16_t> slots;
  std::vector<glm::uvec3> normal_ids;

  MeshData data() const { return {vertices, triangles, slots, normal_ids}; }
};

/// The message of the std::invalid_argument that `action` throws, or "nothing was thrown".
template <typename Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace regraft::test
