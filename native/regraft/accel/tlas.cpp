#include "regraft/accel/tlas.h"

#include <algorithm>

#include "regraft/accel/triangle_bounds.h"
#include "regraft/bvh/binned_sah_builder.h"
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

void Tlas::collect_primitives(const Scene& scene, const InstanceSet& instances,
                              Executor& executor) {
  const auto views = instances.views();
  ids_.clear();
  flat_.clear();
  if (layout_ == Layout::two_level) {
    boxes_.resize(views.size());
  } else {
    for (std::uint32_t i = 0; i < views.size(); ++i)
      for (const std::uint32_t prim : instances.tree(i).bvh().prim_ids) flat_.push_back({i, prim});
    boxes_.resize(flat_.size());
  }
  measure(scene, instances, executor);
  for (std::uint32_t i = 0; i < boxes_.size(); ++i)
    if (!boxes_[i].empty()) ids_.push_back(i);
}

void Tlas::measure(const Scene& scene, const InstanceSet& instances, Executor& executor) {
  executor.parallel_for(boxes_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (layout_ == Layout::flat) {
        boxes_[i] = flat_bounds(scene, instances, flat_[i]);
        continue;
      }
      const trace::InstanceView& v = instances.views()[i];
      boxes_[i] = {Vec3(v.lo[0], v.lo[1], v.lo[2]), Vec3(v.hi[0], v.hi[1], v.hi[2])};
    }
  });
}

TreeWork Tlas::update(const Scene& scene, const InstanceSet& instances, Layout layout,
                      bool set_changed, bool moved, Policy policy, int width, Executor& executor) {
  const bool topology = set_changed || layout != layout_ || width != wide_.width();
  layout_ = layout;
  TreeState state{exists_, topology, moved, now_.wear(built_)};
  TreeWork work{choose_update(state, policy)};
  if (work.done == TreeUpdate::refit) {
    measure(scene, instances, executor);
    now_ = refit(executor);
    work.nodes_refitted = now_.nodes;
    state.wear = now_.wear(built_);
    state.topology_changed = !holds_all();
    work.done = choose_update(state, policy);
    if (work.done == TreeUpdate::refit) wide_.refit(bvh_, executor);
  }
  if (work.done == TreeUpdate::rebuild) {
    collect_primitives(scene, instances, executor);
    bvh::BinnedSahBuilder::Config config;
    if (layout_ == Layout::two_level) {
      // Entering an instance means a transform and a tree of its own: never two in one leaf.
      config.max_leaf = 1;
    }
    bvh_ = bvh::BinnedSahBuilder::build(boxes_, ids_, config, executor);
    wide_ = bvh::WideBvh::derive(bvh_, width, executor);
    now_ = built_ = refit(executor);
    work.nodes_rebuilt = bvh_.node_count();
    exists_ = true;
  }
  return work;
}

/// False if something that had no box when the tree was built, and so is not in it, has one now.
bool Tlas::holds_all() const {
  if (ids_.size() == boxes_.size()) return true;
  for (std::uint32_t i = 0; i < boxes_.size(); ++i)
    if (!boxes_[i].empty() && !std::binary_search(ids_.begin(), ids_.end(), i)) return false;
  return true;
}

bvh::RefitResult Tlas::refit(Executor& executor) {
  return bvh::refit(
      bvh_, [&](std::uint32_t i) { return bvh::Box4(boxes_[i]); }, executor);
}

double Tlas::sah_cost(const InstanceSet& instances) const {
  return layout_ == Layout::flat ? now_.sah_cost : cost_through(instances, false);
}

double Tlas::unworn_cost(const InstanceSet& instances) const {
  const double below = layout_ == Layout::flat ? now_.sah_cost : cost_through(instances, true);
  return below / now_.wear(built_);
}

double Tlas::cost_through(const InstanceSet& instances, bool unworn) const {
  double sum = 0.0;
  const Aabb root = bvh_.bounds();
  for (std::size_t n = 0; n < bvh_.nodes.size(); ++n) {
    if (n == 1) continue;
    const bvh::Node& node = bvh_.nodes[n];
    const double probability = hit_probability(node.bounds(), root);
    if (!node.leaf()) {
      sum += probability;
      continue;
    }
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const Blas& tree = instances.tree(bvh_.prim_ids[node.first + i]);
      sum += probability * (unworn ? tree.sah_cost() / tree.wear() : tree.sah_cost());
    }
  }
  return sum;
}

void Tlas::show(trace::TraceView& view) const {
  view.top_nodes = nullptr;
  if (!wide_.empty())
    view.top_nodes = wide_.width() == 8 ? static_cast<const void*>(wide_.nodes<8>())
                                        : static_cast<const void*>(wide_.nodes<4>());
  view.width = wide_.width();
  view.top_prims = bvh_.prim_ids.data();
  view.flat = layout_ == Layout::flat ? flat_.data() : nullptr;
  view.magnitude = bvh_.bounds().magnitude();
}

std::size_t Tlas::bytes() const {
  return bvh_.bytes() + wide_.bytes() + boxes_.capacity() * sizeof(Aabb) +
         flat_.capacity() * sizeof(trace::FlatPrim) + ids_.capacity() * sizeof(std::uint32_t);
}

std::string Tlas::validate() const {
  return bvh::validate(bvh_, boxes_, ids_);
}

}  // namespace regraft::accel
