#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "regraft/core/aabb.h"

namespace regraft {

/// Corner id of a flat-shaded corner.
inline constexpr std::uint32_t flat_corner = 0xFFFFFFFFu;

using Triangle = glm::uvec3;

/// Vertices are watched for motion in blocks of so many neighbours.
inline constexpr std::uint32_t vertex_block = 64;

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
  /// Counts how often positions have changed; by block of vertices, its value when the block last
  /// did. Who remembers the count sees later what has moved since, blocks of a larger value.
  /// Empty: nothing is known of blocks.
  std::uint32_t revision = 0;
  std::vector<std::uint32_t> block_revisions;
  /// Positions in key frames of the shot, if the host has told.
  std::vector<std::vector<Vec3>> key_vertices;

  /// Of the arrays, with what they have in reserve.
  std::size_t bytes() const;
};

/// Takes over positions, as many as there are, block by block where they are not the same bits.
/// @return whether any were not.
bool move_vertices(Mesh& mesh, std::span<const Vec3> vertices);

/// `mesh 3 "Cube"`, as error messages call it.
std::string label(const Mesh& mesh, std::uint32_t id);

/// New content of a mesh; the spans are read during the call only.
struct MeshData {
  std::span<const Vec3> vertices;
  std::span<const Triangle> triangles;
  std::span<const std::uint16_t> slots;    ///< empty or one a triangle
  std::span<const glm::uvec3> normal_ids;  ///< empty or one a triangle
};

/// How many shading normals `data` names. Throws std::invalid_argument, calling the mesh `label`,
/// if counts do not agree or an index or normal id is out of range.
std::uint32_t check_mesh_data(const MeshData& data, const std::string& label);

/// Box of triangle `t`; empty if a vertex is not finite (such a triangle cannot be hit).
Aabb triangle_bounds(const Mesh& mesh, std::uint32_t t);

/// True if the triangle cannot be hit whatever the ray: a vertex is not finite or the exact
/// cross product of its edges is zero (numerics rule N8).
bool is_degenerate(const Mesh& mesh, std::uint32_t t);
bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace regraft
