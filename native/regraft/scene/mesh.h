#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "regraft/core/aabb.h"

namespace regraft {

/// Corner id of a flat-shaded corner.
inline constexpr std::uint32_t flat_corner = 0xFFFFFFFFu;

using Triangle = glm::uvec3;

/// Triangles in object space. Owned by `Scene`, addressed by mesh id.
struct Mesh {
  std::string name;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  /// Material slot of each triangle; empty: all 0.
  std::vector<std::uint16_t> slots;
  /// Corners with the same number share a shading normal; empty: flat.
  std::vector<glm::uvec3> normal_ids;
  /// How many shading normals `normal_ids` names.
  std::uint32_t normal_count = 0;
  std::uint32_t instance_count = 0;
  bool alive = false;

  std::size_t bytes() const;
};

/// Box of triangle `t`; empty if a vertex is not finite (such a triangle cannot be hit).
Aabb triangle_bounds(const Mesh& mesh, std::uint32_t t);

/// True if the triangle cannot be hit whatever the ray: a vertex is not finite or the exact
/// cross product of its edges is zero (numerics rule N8).
bool is_degenerate(const Mesh& mesh, std::uint32_t t);

}  // namespace regraft
