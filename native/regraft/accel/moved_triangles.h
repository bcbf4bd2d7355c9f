#pragma once

#include <cstdint>
#include <vector>

#include "regraft/accel/motion.h"
#include "regraft/core/executor.h"
#include "regraft/scene/mesh.h"

namespace regraft::accel {

/// Finds the triangles of a mesh that have moved through the blocks of vertices that have. What
/// blocks triangles hang on is listed when it is first needed: a mesh that never moves in part pays
/// nothing.
class MovedTriangles {
 public:
  /// The mesh is known as it is now, and may have other triangles than before.
  void reset(const Mesh& mesh);

  /// What has moved since this or `reset` was last called; valid until either is called again.
  /// O(blocks of vertices), and O(1) for each triangle that hangs on one that moved.
  Motion take(const Mesh& mesh, Executor& executor);

  std::size_t bytes() const;

 private:
  void list(const Mesh& mesh, Executor& executor);

  std::uint32_t revision_ = 0;
  /// Triangles by block of vertices, ascending, once in each block; where a block's begin.
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint8_t> is_moved_;  ///< by block
  std::vector<std::uint32_t> moved_;
};

}  // namespace regraft::accel
