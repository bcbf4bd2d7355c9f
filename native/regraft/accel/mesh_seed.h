#pragma once

#include <mutex>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/core/executor.h"
#include "regraft/scene/mesh.h"

namespace regraft::accel {

/// A rough tree over a mesh's triangles as they lie in memory, to seed a k-d tree with; made when
/// somebody first asks for it. Much cheaper than a tree for rays: neighbours in memory are mostly
/// neighbours in space, so runs of triangles are its primitives. Where they are not, runs are
/// halved down to single triangles.
class MeshSeed {
 public:
  /// Triangles first … first + count of the mesh.
  struct Run {
    std::uint32_t first;
    std::uint32_t count;
  };
  static constexpr std::uint32_t longest_run = 8;

  /// Reads the mesh, once. May be called from several threads at once.
  void read(const Mesh& mesh, Executor& executor);

  /// After `read`: its primitives are runs, one a leaf. Every child comes after its parent.
  const bvh::Bvh& bvh() const { return bvh_; }
  const Run& run(std::uint32_t leaf_prim) const { return runs_[leaf_prim]; }
  /// Triangles below a node.
  std::uint32_t weight(std::uint32_t node) const { return weights_[node]; }
  std::size_t bytes() const;

 private:
  void build(const Mesh& mesh, Executor& executor);

  std::once_flag once_;
  bvh::Bvh bvh_;
  std::vector<Run> runs_;
  std::vector<std::uint32_t> weights_;
};

}  // namespace regraft::accel
