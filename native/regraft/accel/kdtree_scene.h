#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "regraft/accel/scene_hierarchy.h"
#include "regraft/kdtree/kdtree.h"

namespace regraft::accel {

/// Keeps the k-d tree of a scene: `structure="kdtree"`.
class KdtreeScene {
 public:
  /// The tree for what `instances` now shows. `changed_meshes[m]`: mesh m's geometry changed.
  /// Everything given, `executor` too, is used while rays are traced.
  void update(const Scene& scene, const InstanceSet& instances,
              std::span<const std::uint8_t> changed_meshes, Executor& executor);
  void clear();

  /// Null: nothing to hit, or another structure is used.
  const kdtree::KdTree* tree() const { return tree_.get(); }
  std::size_t bytes() const;
  /// The first violation of the tree's invariants in words, or "".
  std::string validate() const;

 private:
  std::vector<std::unique_ptr<MeshSeed>> seeds_;  ///< by mesh id; kept while the mesh is as it was
  std::unique_ptr<SceneHierarchy> hierarchy_;
  std::unique_ptr<kdtree::KdTree> tree_;
};

}  // namespace regraft::accel
