#include "regraft/accel/scene_hierarchy.h"

#include <cmath>

#include "regraft/accel/triangle_bounds.h"
#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/refit.h"
#include "regraft/core/rounding.h"
#include "regraft/kdtree/clip.h"

namespace regraft::accel {

namespace {

/// Box of points, rounded outward.
struct Extent {
  Vec3d lo{std::numeric_limits<double>::infinity()};
  Vec3d hi{-std::numeric_limits<double>::infinity()};

  Aabb widened(const Vec3d& margin) const {
    Aabb box;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = round_down(lo[k] - margin[k]);
      box.hi[k] = round_up(hi[k] + margin[k]);
    }
    return box;
  }
};

Aabb world_box(const trace::InstanceView& view) {
  return {{view.lo[0], view.lo[1], view.lo[2]}, {view.hi[0], view.hi[1], view.hi[2]}};
}

}  // namespace

SceneHierarchy::SceneHierarchy(const Scene& scene, const InstanceSet& instances,
                               std::vector<std::unique_ptr<MeshSeed>>& seeds, Executor& executor)
    : instances_(instances), executor_(executor) {
  for (std::size_t i = 0; i < instances.views().size(); ++i)
    places_.push_back(place(scene, seeds, i));
  build_groups(scene);
}

SceneHierarchy::Place SceneHierarchy::place(const Scene& scene,
                                            std::vector<std::unique_ptr<MeshSeed>>& seeds,
                                            std::size_t i) {
  const trace::InstanceView& view = instances_.views()[i];
  const std::uint32_t id = scene.instances()[view.instance_id].mesh;
  const Mesh& mesh = instances_.mesh(scene, i);
  const bool baked = &mesh != &scene.meshes()[id];
  if (baked) baked_seeds_[i].reset();
  std::unique_ptr<MeshSeed>& seed = baked ? baked_seeds_[i] : seeds[id];
  if (!seed) seed = std::make_unique<MeshSeed>();
  const bool exact = view.identity && instances_.origin() == Vec3d(0.0);
  const Aabb box = world_box(view);
  Place place{instances_.frame(i), Vec3d(0.0), &mesh, seed.get(), box, exact};
  if (!exact) place.margin = placement_margin(place.frame, box, view.mesh.magnitude);
  return place;
}

std::vector<Aabb> SceneHierarchy::update(const Scene& scene,
                                         std::vector<std::unique_ptr<MeshSeed>>& seeds,
                                         std::span<const std::size_t> moved) {
  std::vector<Aabb> regions;
  for (const std::size_t i : moved) {
    regions.push_back(places_[i].box);
    places_[i] = place(scene, seeds, i);
    regions.push_back(places_[i].box);
  }
  // Meshes that did not change may lie elsewhere in memory.
  for (std::size_t i = 0; i < places_.size(); ++i) places_[i].mesh = &instances_.mesh(scene, i);
  for (std::size_t g = groups_.size(); g-- > 0;) {
    // The outermost is the last, but what it holds comes first.
    GroupTree& tree = groups_[(g + groups_.size() - 1) % groups_.size()];
    for (HierarchyEntry& member : tree.members)
      member =
          member.kind == group_node ? group_entry(member.object, 0) : mesh_entry(member.object, 0);
    if (!tree.members.empty()) tree.refit(executor_);
  }
  return regions;
}

void SceneHierarchy::build_groups(const Scene& scene) {
  const auto outermost = std::uint32_t(scene.groups().size());
  const auto slot = [&](std::uint32_t group) { return group == invalid_id ? outermost : group; };
  groups_.resize(outermost + 1);
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    const Instance& instance = scene.instances()[instances_.views()[i].instance_id];
    if (!world_box(instances_.views()[i]).empty())
      groups_[slot(instance.group)].members.push_back(mesh_entry(i, 0));
  }
  // Groups come after their parents, so that a group is complete before it becomes a member.
  for (std::uint32_t g = outermost + 1; g-- > 0;) {
    const std::uint32_t group = g == 0 ? outermost : g - 1;
    GroupTree& tree = groups_[group];
    if (tree.members.empty()) continue;
    tree.build(executor_);
    if (group != outermost)
      groups_[slot(scene.groups()[group].parent)].members.push_back(group_entry(group, 0));
  }
}

void SceneHierarchy::GroupTree::build(Executor& executor) {
  std::vector<Aabb> boxes;
  std::vector<std::uint32_t> ids;
  for (const HierarchyEntry& member : members) {
    ids.push_back(std::uint32_t(boxes.size()));
    boxes.push_back(member.box);
  }
  bvh = bvh::BinnedSahBuilder::build(boxes, ids, {}, executor);
  weigh();
}

void SceneHierarchy::GroupTree::refit(Executor& executor) {
  bvh::refit(
      bvh, [&](std::uint32_t i) { return bvh::Box4(members[i].box); }, executor);
  weigh();
}

void SceneHierarchy::GroupTree::weigh() {
  weights.assign(bvh.nodes.size(), 0.0);
  // Children come after their parents.
  for (std::size_t n = bvh.nodes.size(); n-- > 0;) {
    const bvh::Node& node = bvh.nodes[n];
    if (n == 1) continue;
    if (!node.leaf()) weights[n] = weights[node.first] + weights[node.first + 1];
    for (std::uint32_t i = 0; i < node.count; ++i)
      weights[n] += members[bvh.prim_ids[node.first + i]].weight;
  }
}

HierarchyEntry SceneHierarchy::group_entry(std::uint32_t group, std::uint32_t node) const {
  const GroupTree& tree = groups_[group];
  return {tree.bvh.nodes[node].bounds(), tree.weights[node], group, group_node, node};
}

HierarchyEntry SceneHierarchy::mesh_entry(std::uint32_t instance, std::uint32_t node) const {
  const trace::InstanceView& view = instances_.views()[instance];
  if (node == 0) {
    return {world_box(view), double(view.mesh.prim_count), instance, mesh_node, 0};
  }
  const MeshSeed& seed = *places_[instance].seed;
  const Aabb box = placed(places_[instance], seed.bvh().nodes[node].bounds());
  return {box, double(seed.weight(node)), instance, mesh_node, node};
}

HierarchyEntry SceneHierarchy::triangle_entry(std::uint32_t instance, std::uint32_t prim) const {
  const Place& place = places_[instance];
  if (place.exact)
    return {fast_triangle_bounds(*place.mesh, prim).aabb(), 1.0, instance, primitive, prim};
  Vec3d corner[3];
  corners(place, prim, corner);
  // One that cannot be hit is nowhere, rather than where its finite corners are.
  const Vec3d sum = corner[0] + corner[1] + corner[2];
  if (!std::isfinite(sum.x + sum.y + sum.z)) return {{}, 1.0, instance, primitive, prim};
  Extent extent;
  for (const Vec3d& p : corner) {
    extent.lo = glm::min(extent.lo, p);
    extent.hi = glm::max(extent.hi, p);
  }
  return {extent.widened(place.margin), 1.0, instance, primitive, prim};
}

Aabb SceneHierarchy::placed(const Place& place, const Aabb& box) const {
  if (place.exact) return box;
  const Vec3d center = 0.5 * (Vec3d(box.lo) + Vec3d(box.hi));
  const Vec3d half = 0.5 * box.extents();
  Extent extent;
  const Mat4d& m = place.frame;
  for (int r = 0; r < 3; ++r) {
    const double c = m[0][r] * center.x + m[1][r] * center.y + m[2][r] * center.z + m[3][r];
    const double h =
        std::fabs(m[0][r]) * half.x + std::fabs(m[1][r]) * half.y + std::fabs(m[2][r]) * half.z;
    extent.lo[r] = c - h;
    extent.hi[r] = c + h;
  }
  return extent.widened(place.margin);
}

void SceneHierarchy::corners(const Place& place, std::uint32_t prim, Vec3d (&out)[3]) const {
  const Triangle& triangle = place.mesh->triangles[prim];
  for (int c = 0; c < 3; ++c) {
    const Vec3d p(place.mesh->vertices[triangle[c]]);
    out[c] = place.exact ? p : Vec3d(place.frame * glm::dvec4(p, 1.0));
  }
}

const MeshSeed& SceneHierarchy::seed(std::uint32_t instance) const {
  const Place& place = places_[instance];
  place.seed->read(*place.mesh, executor_);
  return *place.seed;
}

void SceneHierarchy::top(std::vector<HierarchyEntry>& out) const {
  const auto outermost = std::uint32_t(groups_.size() - 1);
  if (!groups_[outermost].members.empty()) out.push_back(group_entry(outermost, 0));
}

void SceneHierarchy::open(const HierarchyEntry& entry, std::vector<HierarchyEntry>& out) const {
  if (entry.kind == group_node) return open_group(entry.object, entry.node, out);
  // The moment to read a mesh: what is never opened is never read.
  const MeshSeed& seed = this->seed(entry.object);
  if (seed.bvh().empty()) return;
  const bvh::Node& node = seed.bvh().nodes[entry.node];
  if (!node.leaf()) {
    for (std::uint32_t child = node.first; child < node.first + 2; ++child)
      out.push_back(mesh_entry(entry.object, child));
    return;
  }
  const MeshSeed::Run& run = seed.run(seed.bvh().prim_ids[node.first]);
  for (std::uint32_t i = 0; i < run.count; ++i) {
    const HierarchyEntry triangle = triangle_entry(entry.object, run.first + i);
    if (!triangle.box.empty()) out.push_back(triangle);
  }
}

void SceneHierarchy::open_group(std::uint32_t group, std::uint32_t index,
                                std::vector<HierarchyEntry>& out) const {
  const GroupTree& tree = groups_[group];
  const bvh::Node& node = tree.bvh.nodes[index];
  if (!node.leaf()) {
    for (std::uint32_t child = node.first; child < node.first + 2; ++child)
      out.push_back(group_entry(group, child));
    return;
  }
  for (std::uint32_t i = 0; i < node.count; ++i)
    out.push_back(tree.members[tree.bvh.prim_ids[node.first + i]]);
}

Aabb SceneHierarchy::clip(const HierarchyEntry& entry, const Aabb& voxel) const {
  const Place& place = places_[entry.object];
  Vec3d corner[3];
  corners(place, entry.node, corner);
  return kdtree::clip_triangle(corner, place.margin, voxel);
}

void SceneHierarchy::clip_sides(const HierarchyEntry& entry, int axis, float position,
                                Aabb (&sides)[2]) const {
  const Place& place = places_[entry.object];
  Vec3d corner[3];
  corners(place, entry.node, corner);
  kdtree::clip_triangle_sides(corner, place.margin, entry.box, axis, position, sides);
}

std::size_t SceneHierarchy::bytes() const {
  std::size_t sum = places_.capacity() * sizeof(Place);
  for (const auto& [instance, seed] : baked_seeds_) sum += seed->bytes();
  for (const GroupTree& tree : groups_)
    sum += tree.members.capacity() * sizeof(HierarchyEntry) + tree.bvh.bytes() +
           tree.weights.capacity() * sizeof(double);
  return sum;
}

}  // namespace regraft::accel
