#include "world_normal.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace regraft::bindings {

Vec3 world_normal(const Scene& scene, std::uint32_t instance_id, std::uint32_t prim_id) {
  const Instance& instance = scene.instances()[instance_id];
  const Mesh& mesh = scene.meshes()[instance.mesh];
  const Triangle& corners = mesh.triangles[prim_id];
  const Vec3d a(mesh.vertices[corners.x]);
  const Vec3d object =
      glm::cross(Vec3d(mesh.vertices[corners.y]) - a, Vec3d(mesh.vertices[corners.z]) - a);
  // (M e1) × (M e2) = cof(M) (e1 × e2): right for mirrored and for flat matrices, and the edges
  // are multiplied before the matrix can round them.
  const Mat3d m(instance.object_to_world);
  const Vec3d world = object.x * glm::cross(m[1], m[2]) + object.y * glm::cross(m[2], m[0]) +
                      object.z * glm::cross(m[0], m[1]);
  // Divided by the largest component first: the squares of tiny or huge ones leave the range.
  const double largest =
      std::fmax(std::fabs(world.x), std::fmax(std::fabs(world.y), std::fabs(world.z)));
  return largest > 0.0 ? Vec3(glm::normalize(world / largest)) : Vec3(0.0f);
}

}  // namespace regraft::bindings
