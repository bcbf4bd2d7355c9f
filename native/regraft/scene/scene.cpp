#include "regraft/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace regraft {

namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw std::invalid_argument(message);
}

/// Why thing `id` cannot be used, or "".
template <typename T>
std::string absence(const std::vector<T>& things, std::uint32_t id, const char* kind) {
  if (id < things.size() && things[id].alive) return "";
  const std::string what = std::string(kind) + " " + std::to_string(id);
  if (id < things.size()) return what + " was removed";
  return what + " does not exist; " + std::to_string(things.size()) + " were ever added";
}

template <typename T>
bool same_bits(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// The last row is 0 0 0 1, but for the rounding of a float32 inverse; NaN passes.
bool is_affine(const Mat4d& m) {
  for (int k = 0; k < 4; ++k) {
    if (std::fabs(m[k][3] - (k == 3 ? 1.0 : 0.0)) > 1e-5) return false;
  }
  return true;
}

std::string not_affine(const Mat4d& m) {
  std::string row;
  for (int k = 0; k < 4; ++k) row += (k == 0 ? "" : ", ") + std::to_string(m[k][3]);
  return "last row of the transform is (" + row + "), (0, 0, 0, 1) wanted";
}

Mat4d affine(Mat4d m) {
  for (int k = 0; k < 4; ++k) m[k][3] = k == 3 ? 1.0 : 0.0;
  return m;
}

void assign(Mesh& mesh, const MeshData& data, std::uint32_t normal_count) {
  mesh.vertices.assign(data.vertices.begin(), data.vertices.end());
  mesh.triangles.assign(data.triangles.begin(), data.triangles.end());
  mesh.slots.assign(data.slots.begin(), data.slots.end());
  mesh.normal_ids.assign(data.normal_ids.begin(), data.normal_ids.end());
  mesh.normal_count = normal_count;
  mesh.block_revisions = {};
}

}  // namespace

std::string label(const Instance& instance, std::uint32_t id) {
  return "instance " + std::to_string(id) + " \"" + instance.name + "\"";
}

Mesh& Scene::checked_mesh(std::uint32_t id) {
  const std::string problem = absence(meshes_, id, "mesh");
  if (!problem.empty()) refuse(problem);
  return meshes_[id];
}

Instance& Scene::checked_instance(std::uint32_t id) {
  const std::string problem = absence(instances_, id, "instance");
  if (!problem.empty()) refuse(problem);
  return instances_[id];
}

std::uint32_t Scene::add_mesh(const MeshData& data, std::string name) {
  Mesh mesh;
  mesh.name = std::move(name);
  mesh.alive = true;
  const auto id = static_cast<std::uint32_t>(meshes_.size());
  assign(mesh, data, check_mesh_data(data, label(mesh, id)));
  meshes_.push_back(std::move(mesh));
  changes_.mesh_added(id);
  return id;
}

void Scene::set_vertices(std::uint32_t id, std::span<const Vec3> vertices) {
  Mesh& mesh = checked_mesh(id);
  if (vertices.size() != mesh.vertices.size()) {
    refuse(label(mesh, id) + ": " + std::to_string(vertices.size()) + " vertices, " +
           std::to_string(mesh.vertices.size()) + " wanted; set_mesh changes their number");
  }
  if (move_vertices(mesh, vertices)) changes_.mesh_deformed(id);
}

void Scene::set_mesh(std::uint32_t id, const MeshData& data) {
  Mesh& mesh = checked_mesh(id);
  assign(mesh, data, check_mesh_data(data, label(mesh, id)));
  mesh.key_vertices = {};
  changes_.mesh_retopologised(id);
}

void Scene::set_key_vertices(std::uint32_t id, std::vector<std::vector<Vec3>> frames) {
  Mesh& mesh = checked_mesh(id);
  for (const std::vector<Vec3>& frame : frames)
    if (frame.size() != mesh.vertices.size())
      refuse(label(mesh, id) + ": key frames of " + std::to_string(frame.size()) + " vertices, " +
             std::to_string(mesh.vertices.size()) + " wanted");
  mesh.key_vertices = std::move(frames);
}

void Scene::set_key_transforms(std::uint32_t id, std::vector<Mat4d> frames) {
  Instance& instance = checked_instance(id);
  for (Mat4d& frame : frames) {
    if (!is_affine(frame)) refuse(label(instance, id) + ": " + not_affine(frame));
    frame = affine(frame);
  }
  instance.key_transforms = std::move(frames);
}

void Scene::remove_mesh(std::uint32_t id) {
  Mesh& mesh = checked_mesh(id);
  if (mesh.instance_count != 0) {
    refuse(label(mesh, id) + " cannot be removed: " + std::to_string(mesh.instance_count) +
           " instances use it");
  }
  mesh = Mesh{};
  changes_.mesh_removed(id);
}

std::uint32_t Scene::add_group(std::uint32_t parent, std::string name) {
  if (parent != invalid_id && parent >= groups_.size()) {
    refuse("group \"" + name + "\": its parent, group " + std::to_string(parent) +
           ", does not exist");
  }
  groups_.push_back({std::move(name), parent});
  return static_cast<std::uint32_t>(groups_.size() - 1);
}

std::uint32_t Scene::material_list(std::span<const std::uint32_t> ids) {
  const auto next = static_cast<std::uint32_t>(material_lists_.size());
  const auto [entry, is_new] =
      material_list_ids_.try_emplace(std::vector(ids.begin(), ids.end()), next);
  if (is_new) material_lists_.push_back(entry->first);
  return entry->second;
}

const Material& Scene::material(const Instance& instance, std::uint32_t slot) const {
  static const Material standard;
  const std::vector<std::uint32_t>& list = material_lists_[instance.material_list];
  if (slot >= list.size() || list[slot] >= materials_.size()) return standard;
  return materials_[list[slot]];
}

void Scene::check_new(const Instance& instance) const {
  std::string problem = absence(meshes_, instance.mesh, "mesh");
  if (instance.group != invalid_id && instance.group >= groups_.size()) {
    problem = "group " + std::to_string(instance.group) + " does not exist";
  }
  if (instance.material_list >= material_lists_.size()) {
    problem = "material list " + std::to_string(instance.material_list) + " does not exist";
  }
  if (!is_affine(instance.object_to_world)) problem = not_affine(instance.object_to_world);
  if (!problem.empty()) refuse("new instance \"" + instance.name + "\": " + problem);
}

std::uint32_t Scene::add_instance(Instance instance) {
  std::vector<Instance> one;
  one.push_back(std::move(instance));
  return add_instances(std::move(one));
}

std::uint32_t Scene::add_instances(std::vector<Instance> added) {
  for (const Instance& instance : added) check_new(instance);
  const auto first = static_cast<std::uint32_t>(instances_.size());
  if (added.size() >= invalid_id - first) refuse("2^32 - 2 instances at most");
  for (Instance& instance : added) {
    instance.object_to_world = affine(instance.object_to_world);
    instance.alive = true;
    ++meshes_[instance.mesh].instance_count;
    changes_.instance_added(static_cast<std::uint32_t>(instances_.size()), instance.visible);
    instances_.push_back(std::move(instance));
  }
  return first;
}

void Scene::place(std::uint32_t id, const Mat4d& object_to_world) {
  Instance& instance = instances_[id];
  const Mat4d matrix = affine(object_to_world);
  if (same_bits<Mat4d>({&instance.object_to_world, 1}, {&matrix, 1})) return;
  instance.object_to_world = matrix;
  changes_.instance_moved(id);
}

void Scene::set_transform(std::uint32_t id, const Mat4d& object_to_world) {
  set_transforms({&id, 1}, {&object_to_world, 1});
}

void Scene::set_transforms(std::span<const std::uint32_t> ids, std::span<const Mat4d> matrices) {
  if (ids.size() != matrices.size()) {
    refuse(std::to_string(matrices.size()) + " transforms for " + std::to_string(ids.size()) +
           " instances");
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Instance& instance = checked_instance(ids[i]);
    if (!is_affine(matrices[i])) refuse(label(instance, ids[i]) + ": " + not_affine(matrices[i]));
  }
  for (std::size_t i = 0; i < ids.size(); ++i) place(ids[i], matrices[i]);
}

void Scene::set_visible(std::uint32_t id, bool visible) {
  Instance& instance = checked_instance(id);
  if (instance.visible == visible) return;
  instance.visible = visible;
  changes_.instance_shown(id, visible);
}

void Scene::set_material_list(std::uint32_t id, std::uint32_t list) {
  Instance& instance = checked_instance(id);
  if (list >= material_lists_.size()) {
    refuse(label(instance, id) + ": material list " + std::to_string(list) + " does not exist");
  }
  instance.material_list = list;
}

void Scene::remove_instance(std::uint32_t id) {
  remove_instances({&id, 1});
}

void Scene::remove_instances(std::span<const std::uint32_t> ids) {
  for (const std::uint32_t id : ids) checked_instance(id);
  std::vector<std::uint32_t> sorted(ids.begin(), ids.end());
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    refuse(label(instances_[*twice], *twice) + " cannot be removed twice");
  }
  for (const std::uint32_t id : ids) {
    --meshes_[instances_[id].mesh].instance_count;
    instances_[id] = Instance{};
    changes_.instance_removed(id);
  }
}

std::size_t Scene::bytes() const {
  std::size_t sum = instances_.capacity() * sizeof(Instance);
  for (const Mesh& mesh : meshes_) sum += sizeof(Mesh) + mesh.bytes();
  return sum;
}

}  // namespace regraft
