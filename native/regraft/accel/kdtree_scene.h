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
  /// What changed since the last call. `meshes[m]`: the geometry of mesh m did.
  struct Changes {
    const InstanceSet::Changes& placed;
    std::span<const std::uint8_t> meshes;
    bool all = false;
  };

  /// The tree for what `instances` now shows. Of a tree that exists only the cells are forgotten
  /// in which something was or is that moved, unless that is much of it.
  /// Everything given but the changes, `executor` too, is used while rays are traced.
  /// @return cells that were forgotten.
  std::uint64_t update(const Scene& scene, const InstanceSet& instances, const Changes& changes,
                       Executor& executor);
  void clear();

  /// Null: nothing to hit, or another structure is used.
  const kdtree::KdTree* tree() const { return tree_.get(); }
  std::size_t bytes() const;
  /// The first violation of the tree's invariants in words, or "".
  std::string validate() const;

 private:
  bool keeps(const InstanceSet& instances, const Changes& changes) const;

  std::vector<std::unique_ptr<MeshSeed>> seeds_;  ///< by mesh id; kept while the mesh is as it was
  std::unique_ptr<SceneHierarchy> hierarchy_;
  std::unique_ptr<kdtree::KdTree> tree_;
};

}  // namespace regraft::accel
