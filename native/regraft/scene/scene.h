#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "regraft/core/aabb.h"
#include "regraft/scene/change_log.h"
#include "regraft/scene/change_set.h"
#include "regraft/scene/instance.h"
#include "regraft/scene/light.h"
#include "regraft/scene/material.h"
#include "regraft/scene/mesh.h"

namespace regraft {

/// What exists, by id, and what changed since it was last asked. Knows no trees.
///
/// Ids are small, dense and reused never while the scene lives. Every mutator checks its
/// arguments and throws std::invalid_argument naming the thing before anything is changed.
class Scene {
 public:
  std::uint32_t add_mesh(const MeshData& data, std::string name);
  /// Positions that are equal bit for bit are no change.
  void set_vertices(std::uint32_t mesh, std::span<const Vec3> vertices);
  void set_mesh(std::uint32_t mesh, const MeshData& data);
  /// Where a mesh's vertices, or an instance, will be in key frames of the shot: no change, but
  /// read when trees are built to last. A mesh forgets them with its triangles.
  void set_key_vertices(std::uint32_t mesh, std::vector<std::vector<Vec3>> frames);
  void set_key_transforms(std::uint32_t instance, std::vector<Mat4d> frames);
  /// Throws while instances use the mesh.
  void remove_mesh(std::uint32_t mesh);

  /// `parent` may be `invalid_id`: a group at the top.
  std::uint32_t add_group(std::uint32_t parent, std::string name);

  /// Index of this list of material ids (one a slot); equal lists share an index.
  std::uint32_t material_list(std::span<const std::uint32_t> ids);
  std::uint32_t add_instance(Instance instance);
  /// All or none; their ids follow each other from the one returned.
  std::uint32_t add_instances(std::vector<Instance> instances);
  /// A matrix that is equal bit for bit is no change. Not finite ones are taken: such an instance
  /// cannot be hit.
  void set_transform(std::uint32_t instance, const Mat4d& object_to_world);
  /// All or none; one matrix an id.
  void set_transforms(std::span<const std::uint32_t> instances, std::span<const Mat4d> matrices);
  void set_visible(std::uint32_t instance, bool visible);
  void set_material_list(std::uint32_t instance, std::uint32_t list);
  void remove_instance(std::uint32_t instance);
  /// All or none; an id given twice throws.
  void remove_instances(std::span<const std::uint32_t> instances);

  void set_materials(std::vector<Material> materials) { materials_ = std::move(materials); }
  void set_lights(std::vector<Light> lights) { lights_ = std::move(lights); }
  void set_world(const Vec3& color) { world_ = color; }

  std::span<const Mesh> meshes() const { return meshes_; }
  std::span<const Instance> instances() const { return instances_; }
  std::span<const Group> groups() const { return groups_; }
  std::span<const Material> materials() const { return materials_; }
  std::span<const Light> lights() const { return lights_; }
  const Vec3& world() const { return world_; }
  /// The material of a slot of an instance; the default one where none was given.
  const Material& material(const Instance& instance, std::uint32_t slot) const;

  ChangeSet changes() const { return changes_.changes(); }
  /// Hands the changes over and starts anew.
  ChangeSet take_changes() { return changes_.take(); }

  std::size_t bytes() const;

 private:
  Mesh& checked_mesh(std::uint32_t id);
  Instance& checked_instance(std::uint32_t id);
  void check_new(const Instance& instance) const;
  void place(std::uint32_t id, const Mat4d& object_to_world);

  std::vector<Mesh> meshes_;
  std::vector<Instance> instances_;
  std::vector<Group> groups_;
  std::vector<std::vector<std::uint32_t>> material_lists_{{}};
  std::map<std::vector<std::uint32_t>, std::uint32_t> material_list_ids_{{{}, 0}};
  std::vector<Material> materials_;
  std::vector<Light> lights_;
  Vec3 world_{0.05f};
  ChangeLog changes_;
};

}  // namespace regraft
