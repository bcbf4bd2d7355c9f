#include "regraft/accel/shading_normals.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace regraft::accel {

namespace {

/// Double: the weight of a corner with edges of 1e-10 m does not fit a float.
Vec3d corner_weight(const Mesh& mesh, std::uint32_t corner) {
  const Triangle& t = mesh.triangles[corner / 3];
  const std::uint32_t c = corner % 3;
  const Vec3d p(mesh.vertices[t[int(c)]]);
  const Vec3d a = Vec3d(mesh.vertices[t[int((c + 1) % 3)]]) - p;
  const Vec3d b = Vec3d(mesh.vertices[t[int((c + 2) % 3)]]) - p;
  const double scale = glm::dot(a, a) * glm::dot(b, b);
  return scale > 0.0 && std::isfinite(scale) ? glm::cross(a, b) / scale : Vec3d(0.0);
}

}  // namespace

void ShadingNormals::list_corners(const Mesh& mesh) {
  begin_.assign(mesh.normal_count + 1, 0);
  for (const glm::uvec3& ids : mesh.normal_ids)
    for (int c = 0; c < 3; ++c)
      if (ids[c] != flat_corner) ++begin_[ids[c] + 1];
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  corners_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t t = 0; t < mesh.normal_ids.size(); ++t)
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t id = mesh.normal_ids[t][int(c)];
      if (id != flat_corner) corners_[next[id]++] = 3 * t + c;
    }
}

void ShadingNormals::update(const Mesh& mesh, bool topology_changed, Executor& executor) {
  if (topology_changed || begin_.size() != std::size_t(mesh.normal_count) + 1) list_corners(mesh);
  normals_.resize(mesh.normal_count);
  executor.parallel_for(normals_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3d sum(0.0);
      for (std::uint32_t c = begin_[i]; c < begin_[i + 1]; ++c)
        sum += corner_weight(mesh, corners_[c]);
      const double length = glm::length(sum);
      const bool usable = length > 0.0 && std::isfinite(length);
      normals_[i] = usable ? Vec3(sum / length) : Vec3(0.0f);
    }
  });
}

std::size_t ShadingNormals::bytes() const {
  return normals_.capacity() * sizeof(Vec3) +
         (begin_.capacity() + corners_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace regraft::accel
