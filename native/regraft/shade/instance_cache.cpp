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

/// Cofactors in double; scaled, because float would lose very large or small ones.
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
  const double scale = largest > 0.0 ? 1.0 / largest : 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) entry.cofactor[i][j] = float(cofactor[i][j] * scale);
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
}

const Material& InstanceCache::load_material(const ShadedInstance& entry, std::uint32_t slot) {
  ShadedInstance& stored = entries_[entry.id % slot_count];
  stored.slot = slot;
  stored.material = &scene_->material(*entry.instance, slot);
  return *stored.material;
}

}  // namespace regraft::shade
