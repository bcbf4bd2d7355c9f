#include "regraft/accel/kdtree_scene.h"

#include "regraft/kdtree/validate.h"

namespace regraft::accel {

void KdtreeScene::update(const Scene& scene, const InstanceSet& instances,
                         std::span<const std::uint8_t> changed_meshes, Executor& executor) {
  tree_.reset();
  seeds_.resize(scene.meshes().size());
  for (std::size_t id = 0; id < seeds_.size(); ++id)
    if (changed_meshes[id] != 0 || !scene.meshes()[id].alive) seeds_[id].reset();
  hierarchy_ = std::make_unique<SceneHierarchy>(scene, instances, seeds_, executor);
  tree_ = std::make_unique<kdtree::KdTree>(*hierarchy_, kdtree::Config{}, executor);
  if (tree_->bounds().empty()) tree_.reset();
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
