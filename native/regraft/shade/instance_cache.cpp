#include "regraft/shade/instance_cache.h"

#include <algorithm>
#include <cmath>

namespace regraft::shade {

namespace {

void set_transform(ShadedInstance& entry, const Mat4d& object_to_world) {
  double stretch = 0.0;
  double translation = 0.0;
  for (int row = 0; row < 3; ++row) {
    double sum = 0.0;
    for (int column = 0; column < 3; ++column) {
      entry.rotation[row][column] = object_to_world[column][row];
      sum += std::fabs(object_to_world[column][row]);
    }
    entry.translation[row] = object_to_world[3][row];
    stretch = std::max(stretch, sum);
    translation = std::max(translation, std::fabs(object_to_world[3][row]));
  }
  entry.stretch = float(stretch);
  entry.translation_size = float(translation);
}

/// Cofactors in double; scaled, because float would lose very large or small ones, and with the
/// determinant's sign, so that a mirrored instance's normals stay on the side they were on.
void set_cofactors(ShadedInstance& entry) {
  const auto& m = entry.rotation;
  double cofactor[3][3];
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      cofactor[i][j] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
      largest = std::max(largest, std::fabs(cofactor[i][j]));
    }
  }
  const double determinant =
      m[0][0] * cofactor[0][0] + m[0][1] * cofactor[0][1] + m[0][2] * cofactor[0][2];
  const double sign = determinant < 0.0 ? -1.0 : 1.0;
  const double scale = largest > 0.0 ? sign / largest : 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) entry.cofactor[i][j] = float(cofactor[i][j] * scale);
}

void set_metric(ShadedInstance& entry) {
  const auto& c = entry.cofactor;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      entry.metric[i][j] = c[0][i] * c[0][j] + (c[1][i] * c[1][j] + c[2][i] * c[2][j]);
  const float tolerance = 1e-3f * entry.metric[0][0];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      entry.conformal &=
          std::fabs(entry.metric[i][j] - (i == j ? entry.metric[0][0] : 0.0f)) <= tolerance;
}

}  // namespace

void InstanceCache::load(ShadedInstance& entry, std::uint32_t id) {
  entry = ShadedInstance{};
  entry.id = id;
  entry.instance = &scene_->instances()[id];
  const std::uint32_t mesh_id = entry.instance->mesh;
  const Mesh& mesh = scene_->meshes()[mesh_id];
  entry.vertices = mesh.vertices.data();
  entry.triangles = mesh.triangles.data();
  if (!mesh.slots.empty()) entry.slots = mesh.slots.data();
  if (!mesh.normal_ids.empty()) {
    entry.normal_ids = mesh.normal_ids.data();
    entry.normals = accelerator_->shading_normals(mesh_id).data();
    met_smooth_ = true;
  }
  set_transform(entry, entry.instance->object_to_world);
  set_cofactors(entry);
  set_metric(entry);
}

const Material& InstanceCache::load_material(const ShadedInstance& entry, std::uint32_t slot) {
  ShadedInstance& stored = entries_[entry.id % slot_count];
  stored.slot = slot;
  stored.material = &scene_->material(*entry.instance, slot);
  return *stored.material;
}

}  // namespace regraft::shade
