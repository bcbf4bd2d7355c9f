#include "regraft/scene/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace regraft {

namespace {

using Components = std::array<double, 6>;

/// True if the exact sum of `terms` is zero. Adds them to a nonoverlapping expansion, which is
/// zero only if all its components are (Shewchuk, Adaptive Precision Floating-Point Arithmetic,
/// Discrete & Computational Geometry 18, 1997, theorem 10, Grow-Expansion).
bool sums_to_zero(const Components& terms) {
  Components expansion{};
  for (std::size_t count = 0; count < terms.size(); ++count) {
    double carry = terms[count];
    for (std::size_t k = 0; k < count; ++k) {
      const double sum = carry + expansion[k];
      const double part = sum - carry;
      expansion[k] = (carry - (sum - part)) + (expansion[k] - part);
      carry = sum;
    }
    expansion[count] = carry;
  }
  return std::all_of(expansion.begin(), expansion.end(), [](double c) { return c == 0.0; });
}

/// True if three points of a plane lie on one line, exactly. The determinant of the edges is
/// accepted beyond its error bound (Shewchuk 1997, section 4.2); within it the six products of
/// coordinates decide: each is exact, as two floats' bits and exponents fit into a double.
bool collinear(double ax, double ay, double bx, double by, double cx, double cy) {
  const double left = (bx - ax) * (cy - ay);
  const double right = (by - ay) * (cx - ax);
  constexpr double error_bound = 3.4e-16;
  if (std::fabs(left - right) > error_bound * (std::fabs(left) + std::fabs(right))) return false;
  return sums_to_zero({ax * by, -ay * bx, bx * cy, -by * cx, cx * ay, -cy * ax});
}

bool finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

[[noreturn]] void refuse(const std::string& message) {
  throw std::invalid_argument(message);
}

void check_count(const std::string& label, const char* what, std::size_t got, std::size_t wanted) {
  if (got == 0 || got == wanted) return;
  refuse(label + ": " + std::to_string(got) + " " + what + " for " + std::to_string(wanted) +
         " triangles; one a triangle or none wanted");
}

/// The highest id in `corners`, plus one, leaving out `flat_corner`.
std::uint32_t used_normals(std::span<const glm::uvec3> corners) {
  std::uint32_t count = 0;
  for (const glm::uvec3& c : corners) {
    for (int k = 0; k < 3; ++k) {
      if (c[k] != flat_corner) count = std::max(count, c[k] + 1);
    }
  }
  return count;
}

}  // namespace

std::size_t Mesh::bytes() const {
  std::size_t keys = 0;
  for (const std::vector<Vec3>& frame : key_vertices) keys += frame.capacity() * sizeof(Vec3);
  return keys + vertices.capacity() * sizeof(Vec3) + triangles.capacity() * sizeof(Triangle) +
         slots.capacity() * sizeof(std::uint16_t) + normal_ids.capacity() * sizeof(glm::uvec3) +
         block_revisions.capacity() * sizeof(std::uint32_t);
}

bool move_vertices(Mesh& mesh, std::span<const Vec3> vertices) {
  const std::uint32_t next = mesh.revision + 1;
  mesh.block_revisions.resize((vertices.size() + vertex_block - 1) / vertex_block, 0);
  for (std::size_t block = 0; block < mesh.block_revisions.size(); ++block) {
    const std::size_t begin = block * vertex_block;
    const std::size_t bytes =
        std::min<std::size_t>(vertex_block, vertices.size() - begin) * sizeof(Vec3);
    if (std::memcmp(&mesh.vertices[begin], &vertices[begin], bytes) == 0) continue;
    std::memcpy(&mesh.vertices[begin], &vertices[begin], bytes);
    mesh.block_revisions[block] = mesh.revision = next;
  }
  return mesh.revision == next;
}

std::string label(const Mesh& mesh, std::uint32_t id) {
  return "mesh " + std::to_string(id) + " \"" + mesh.name + "\"";
}

std::uint32_t check_mesh_data(const MeshData& data, const std::string& label) {
  const std::size_t triangles = data.triangles.size();
  const std::size_t vertices = data.vertices.size();
  if (std::max(triangles, vertices) >= invalid_id) refuse(label + ": 2^32 - 2 elements at most");
  check_count(label, "slots", data.slots.size(), triangles);
  check_count(label, "normal_ids", data.normal_ids.size(), triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    const Triangle& corners = data.triangles[t];
    const std::uint32_t highest = std::max({corners.x, corners.y, corners.z});
    if (highest < vertices) continue;
    refuse(label + ": triangle " + std::to_string(t) + " names vertex " + std::to_string(highest) +
           ", but there are " + std::to_string(vertices) + " vertices");
  }
  // Ids number the normals: more of them than corners or vertices is a mistake, and would take
  // memory for normals that nobody has.
  const std::uint32_t normals = used_normals(data.normal_ids);
  const std::size_t most = std::max(vertices, 3 * triangles);
  if (normals > most) {
    refuse(label + ": normal id " + std::to_string(normals - 1) + ", below " +
           std::to_string(most) + " wanted (vertices, or corners if more)");
  }
  return normals;
}

Aabb triangle_bounds(const Mesh& mesh, std::uint32_t t) {
  Aabb box;
  for (int k = 0; k < 3; ++k) {
    const Vec3& p = mesh.vertices[mesh.triangles[t][k]];
    if (!finite(p)) return {};
    box.extend(p);
  }
  return box;
}

bool is_degenerate(const Mesh& mesh, std::uint32_t t) {
  const Triangle& corners = mesh.triangles[t];
  return is_degenerate(mesh.vertices[corners.x], mesh.vertices[corners.y],
                       mesh.vertices[corners.z]);
}

bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c) {
  if (!finite(a) || !finite(b) || !finite(c)) return true;
  return collinear(a.x, a.y, b.x, b.y, c.x, c.y) && collinear(a.y, a.z, b.y, b.z, c.y, c.z) &&
         collinear(a.z, a.x, b.z, b.x, c.z, c.x);
}

}  // namespace regraft
