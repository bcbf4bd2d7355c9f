#include "regraft/accel/kdtree_scene.h"

#include "regraft/kdtree/validate.h"

namespace regraft::accel {

namespace {

/// Above this share of instances in motion a new tree is cheaper than looking for their cells.
constexpr double most_moved = 0.25;

Aabb world_box(const trace::InstanceView& view) {
  return {{view.lo[0], view.lo[1], view.lo[2]}, {view.hi[0], view.hi[1], view.hi[2]}};
}

}  // namespace

/// Whether the tree may stay, but for the cells of what moved.
bool KdtreeScene::keeps(const InstanceSet& instances, const Changes& changes) const {
  const auto& moved = changes.placed.moved;
  if (!tree_ || changes.all || changes.placed.set_changed) return false;
  if (double(moved.size()) > most_moved * double(instances.views().size())) return false;
  for (const std::size_t i : moved) {
    const Aabb box = world_box(instances.views()[i]);
    if (box.empty() || !tree_->bounds().contains(box)) return false;
  }
  return 2 * tree_->forgotten() <= tree_->made();
}

std::uint64_t KdtreeScene::update(const Scene& scene, const InstanceSet& instances,
                                  const Changes& changes, Executor& executor) {
  const bool kept = keeps(instances, changes);
  if (!kept) tree_.reset();
  seeds_.resize(scene.meshes().size());
  for (std::size_t id = 0; id < seeds_.size(); ++id)
    if (changes.meshes[id] != 0 || !scene.meshes()[id].alive) seeds_[id].reset();
  if (kept) {
    const std::uint64_t before = tree_->forgotten();
    tree_->invalidate(hierarchy_->update(scene, seeds_, changes.placed.moved));
    return tree_->forgotten() - before;
  }
  hierarchy_ = std::make_unique<SceneHierarchy>(scene, instances, seeds_, executor);
  tree_ = std::make_unique<kdtree::KdTree>(*hierarchy_, kdtree::Config{}, executor);
  if (tree_->bounds().empty()) tree_.reset();
  return 0;
}

void KdtreeScene::clear() {
  tree_.reset();
  hierarchy_.reset();
  seeds_.clear();
}

std::size_t KdtreeScene::bytes() const {
  std::size_t sum = tree_ ? tree_->bytes() + hierarchy_->bytes() : 0;
  for (const auto& seed : seeds_)
    if (seed) sum += seed->bytes();
  return sum;
}

std::string KdtreeScene::validate() const {
  return tree_ ? kdtree::validate(*tree_) : "";
}

}  // namespace regraft::accel
