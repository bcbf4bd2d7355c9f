#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "regraft/accel/instance_set.h"
#include "regraft/accel/mesh_seed.h"
#include "regraft/core/hierarchy_view.h"
#include "regraft/scene/scene.h"

namespace regraft::accel {

/// A scene as a k-d tree sees it: groups → instances → nodes of the meshes' seeds → triangles, in
/// world coordinates relative to `InstanceSet::origin`. A primitive's object is an index into
/// `InstanceSet::views`.
///
/// A group's members are arranged in a small tree by place, since groups of thousands would make
/// every list as long; all instances of a mesh share the nodes of its tree, whose boxes and
/// triangles are taken to the world when they are asked for.
class SceneHierarchy final : public HierarchyView {
 public:
  /// Kinds of entries.
  enum Kind : std::uint32_t { primitive, group_node, mesh_node };

  /// Bounds every instance; reads no mesh until it is opened. `seeds` by mesh id; missing ones are
  /// made. All arguments must stay as they are.
  SceneHierarchy(const Scene& scene, const InstanceSet& instances,
                 std::vector<std::unique_ptr<MeshSeed>>& seeds, Executor& executor);

  /// Follows the motion of instances `moved`, of the same set as before; seeds of meshes that
  /// changed are gone.
  /// @return where the hierarchy is no longer what it was: the old and the new box of each.
  std::vector<Aabb> update(const Scene& scene, std::vector<std::unique_ptr<MeshSeed>>& seeds,
                           std::span<const std::size_t> moved);

  void top(std::vector<HierarchyEntry>& out) const override;
  void open(const HierarchyEntry& entry, std::vector<HierarchyEntry>& out) const override;
  Aabb clip(const HierarchyEntry& primitive, const Aabb& voxel) const override;
  void clip_sides(const HierarchyEntry& primitive, int axis, float position,
                  Aabb (&sides)[2]) const override;
  std::uint32_t fan_out() const override { return MeshSeed::longest_run; }

  std::size_t bytes() const;

 private:
  /// Members of a group: other groups and instances.
  struct GroupTree {
    std::vector<HierarchyEntry> members;
    bvh::Bvh bvh;
    std::vector<double> weights;  ///< of every node

    void build(Executor& executor);
    void refit(Executor& executor);
    void weigh();
  };
  /// How an instance's triangles get to the world.
  struct Place {
    Mat4d frame;
    Vec3d margin;  ///< what rounding may take for part of a triangle; see `transform_bounds`
    const Mesh* mesh;
    MeshSeed* seed;
    Aabb box;    ///< in the world
    bool exact;  ///< coordinates are the mesh's own
  };

  Place place(const Scene& scene, std::vector<std::unique_ptr<MeshSeed>>& seeds, std::size_t i);
  void build_groups(const Scene& scene);
  void open_group(std::uint32_t group, std::uint32_t node, std::vector<HierarchyEntry>& out) const;
  HierarchyEntry group_entry(std::uint32_t group, std::uint32_t node) const;
  HierarchyEntry mesh_entry(std::uint32_t instance, std::uint32_t node) const;
  HierarchyEntry triangle_entry(std::uint32_t instance, std::uint32_t prim) const;
  Aabb placed(const Place& place, const Aabb& box) const;
  void corners(const Place& place, std::uint32_t prim, Vec3d (&out)[3]) const;
  const MeshSeed& seed(std::uint32_t instance) const;

  const InstanceSet& instances_;
  Executor& executor_;
  std::vector<Place> places_;                                     ///< by instance
  std::map<std::size_t, std::unique_ptr<MeshSeed>> baked_seeds_;  ///< by instance
  std::vector<GroupTree> groups_;  ///< by group id; the last holds what is in none
};

}  // namespace regraft::accel
