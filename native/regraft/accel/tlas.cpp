#include "regraft/accel/tlas.h"

#include <algorithm>

#include "regraft/accel/key_boxes.h"
#include "regraft/accel/triangle_bounds.h"
#include "regraft/bvh/validate.h"

namespace regraft::accel {

namespace {

/// World box of a triangle of the flat layout: exact for identity placements, otherwise the box
/// of the object-space box's image, which no hit in object space can leave.
Aabb flat_bounds(const Scene& scene, const InstanceSet& instances, const trace::FlatPrim& prim) {
  const Aabb local =
      fast_triangle_bounds(instances.mesh(scene, prim.instance), prim.prim_id).aabb();
  const trace::InstanceView& view = instances.views()[prim.instance];
  if (view.identity && instances.origin() == Vec3d(0.0)) return local;
  return transform_bounds(instances.frame(prim.instance), local, view.mesh.magnitude);
}

}  // namespace

bvh::BinnedSahBuilder::Config Tlas::builder() const {
  bvh::BinnedSahBuilder::Config config;
  // Entering an instance means a transform and a tree of its own: never two in one leaf.
  if (layout_ == Layout::two_level) config.max_leaf = 1;
  return config;
}

void Tlas::collect_primitives(const Scene& scene, const InstanceSet& instances,
                              Executor& executor) {
  const auto views = instances.views();
  const bool is_flat = layout_ == Layout::flat;
  flat_.clear();
  begin_.assign(1, 0);
  for (std::uint32_t i = 0; i < views.size(); ++i) {
    if (is_flat)
      for (const std::uint32_t prim : instances.tree(i).prims()) flat_.push_back({i, prim});
    begin_.push_back(is_flat ? std::uint32_t(flat_.size()) : i + 1);
  }
  boxes_.resize(begin_.back());
  for (std::size_t i = 0; i < views.size(); ++i) measure(scene, instances, i, executor);
}

void Tlas::list_boxed() {
  ids_.clear();
  for (std::uint32_t i = 0; i < boxes_.size(); ++i)
    if (!boxes_[i].empty()) ids_.push_back(i);
}

Aabb Tlas::box_of(const Scene& scene, const InstanceSet& instances, std::uint32_t prim) const {
  if (layout_ == Layout::flat) return flat_bounds(scene, instances, flat_[prim]);
  const trace::InstanceView& v = instances.views()[prim];
  return {Vec3(v.lo[0], v.lo[1], v.lo[2]), Vec3(v.hi[0], v.hi[1], v.hi[2])};
}

/// All primitives of an instance.
void Tlas::measure(const Scene& scene, const InstanceSet& instances, std::size_t instance,
                   Executor& executor) {
  const std::uint32_t first = begin_[instance];
  const std::uint32_t count = begin_[instance + 1] - first;
  executor.parallel_for(count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto prim = std::uint32_t(first + i);
      boxes_[prim] = box_of(scene, instances, prim);
    }
  });
}

/// Lists the primitives of an instance that moved. @return false if all of them may have.
bool Tlas::list_moved(const InstanceSet& instances, std::size_t instance, bool as_a_whole) {
  if (layout_ == Layout::two_level) {
    moved_.push_back(std::uint32_t(instance));
    return true;
  }
  const Blas& mesh = instances.tree(instance);
  if (as_a_whole || mesh.motion().all) return false;
  for (const std::uint32_t t : mesh.motion().prims)
    if (const std::uint32_t place = mesh.place(t); place != invalid_id)
      moved_.push_back(begin_[instance] + place);
  return true;
}

/// Boxes of what moved; in the flat layout of the triangles that did, where meshes know them.
Motion Tlas::measure_moved(const Scene& scene, const InstanceSet& instances,
                           const InstanceSet::Changes& placed, Executor& executor) {
  moved_.clear();
  std::vector<std::size_t> whole;
  for (std::size_t i = 0; i < placed.moved.size(); ++i)
    if (!list_moved(instances, placed.moved[i], placed.as_a_whole[i] != 0))
      whole.push_back(placed.moved[i]);
  executor.parallel_for(moved_.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      boxes_[moved_[i]] = box_of(scene, instances, moved_[i]);
  });
  executor.parallel_for(whole.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) measure(scene, instances, whole[i], executor);
  });
  std::size_t count = moved_.size();
  for (const std::size_t i : whole) count += begin_[i + 1] - begin_[i];
  if (count * few_share > boxes_.size()) return {};
  for (const std::size_t i : whole)
    for (std::uint32_t p = begin_[i]; p < begin_[i + 1]; ++p) moved_.push_back(p);
  return {false, moved_};
}

/// Entering an instance costs what its tree costs.
void Tlas::weigh(const InstanceSet& instances) {
  std::vector<double> costs;
  for (std::size_t i = 0; i < instances.views().size() && layout_ == Layout::two_level; ++i)
    costs.push_back(1.0 + instances.tree(i).sah_cost());
  tree_.set_prim_costs(std::move(costs));
}

TreeWork Tlas::update(const Scene& scene, const InstanceSet& instances,
                      const InstanceSet::Changes& placed, Layout layout, const Tending& how,
                      Executor& executor) {
  const bool other_prims = placed.set_changed || layout != layout_;
  const bool may_edit = layout == layout_ && !placed.new_places.empty();
  layout_ = layout;
  TreeWork work;
  work.done = tree_.choose(other_prims, !placed.moved.empty(), how);
  if (work.done == TreeUpdate::none) return work;
  weigh(instances);
  if (other_prims && may_edit && edit(scene, instances, placed, how, executor, work)) return work;
  const auto box = [&](std::uint32_t i) { return bvh::Box4(boxes_[i]); };
  Motion motion;
  if (!other_prims && tree_.exists()) motion = measure_moved(scene, instances, placed, executor);
  if (work.done != TreeUpdate::rebuild && holds_all()) {
    tree_.refit(box, motion, how, executor);
    tree_.mend(box, builder(), how, executor, work);
  } else {
    work.done = TreeUpdate::rebuild;
  }
  if (work.done == TreeUpdate::rebuild) {
    if (other_prims || !tree_.exists()) collect_primitives(scene, instances, executor);
    list_boxed();
    KeyBoxes keys;
    if (how.policy == Policy::shot) keys = key_boxes(scene, instances, flat_, executor);
    tree_.build({boxes_, ids_, builder(), keys}, how, executor);
    work.nodes_rebuilt = bvh().node_count();
  }
  return work;
}

/// False if something that had no box when the tree was built, and so is not in it, has one now.
bool Tlas::holds_all() const {
  if (ids_.size() == boxes_.size()) return true;
  auto held = ids_.begin();
  for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
    if (held != ids_.end() && *held == i)
      ++held;
    else if (!boxes_[i].empty())
      return false;
  }
  return true;
}

double Tlas::sah_cost(const InstanceSet& instances) const {
  return layout_ == Layout::flat
             ? tree_.sah_cost()
             : cost_through(instances, [](const Blas& blas) { return blas.sah_cost(); });
}

double Tlas::culling_efficiency(const InstanceSet& instances) const {
  if (layout_ == Layout::flat) return tree_.culling_efficiency();
  return cost_through(instances, [](const Blas& blas) { return blas.culling_efficiency(); });
}

double Tlas::unworn_cost(const InstanceSet& instances) const {
  const auto unworn = [](const Blas& blas) { return blas.sah_cost() / blas.wear(); };
  const double below = layout_ == Layout::flat ? tree_.sah_cost() : cost_through(instances, unworn);
  return below / tree_.wear();
}

double Tlas::cost_through(const InstanceSet& instances,
                          const std::function<double(const Blas&)>& cost) const {
  const bvh::Bvh& tree = bvh();
  double sum = 0.0;
  const Aabb root = tree.bounds();
  std::vector<std::uint32_t> open;
  if (!tree.empty()) open.push_back(0);
  while (!open.empty()) {
    const bvh::Node& node = tree.nodes[open.back()];
    open.pop_back();
    const double probability = hit_probability(node.bounds(), root);
    if (!node.leaf()) {
      sum += probability;
      open.insert(open.end(), {node.first, node.first + 1});
      continue;
    }
    for (std::uint32_t i = 0; i < node.count; ++i)
      sum += probability * cost(instances.tree(tree.prim_ids[node.first + i]));
  }
  return sum;
}

void Tlas::show(trace::TraceView& view) const {
  view.top_nodes = tree_.wide_nodes();
  view.entered = tree_.entered();
  view.width = tree_.width();
  view.top_prims = bvh().prim_ids.data();
  view.flat = layout_ == Layout::flat ? flat_.data() : nullptr;
  view.magnitude = bounds().magnitude();
}

std::size_t Tlas::bytes() const {
  return tree_.bytes() + boxes_.capacity() * sizeof(Aabb) +
         flat_.capacity() * sizeof(trace::FlatPrim) +
         (ids_.capacity() + begin_.capacity() + moved_.capacity()) * sizeof(std::uint32_t);
}

std::string Tlas::validate() const {
  return bvh::validate(bvh(), boxes_, ids_);
}

}  // namespace regraft::accel
