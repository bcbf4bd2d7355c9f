#pragma once

#include <span>
#include <vector>

#include "regraft/core/executor.h"
#include "regraft/scene/mesh.h"

namespace regraft::accel {

/// Shading normals of a mesh, by the numbers in `Mesh::normal_ids`, object space, unit length
/// (zero where the corners cancel out).
///
/// Weights: Max, Weights for Computing Vertex Normals from Facet Normals, JGT 1999, Eq. 2 – the
/// cross product over the squared lengths of the two edges; exact on a sphere, no trigonometry.
class ShadingNormals {
 public:
  /// `topology_changed`: `normal_ids` may be new; otherwise only positions are.
  void update(const Mesh& mesh, bool topology_changed, Executor& executor);
  std::span<const Vec3> normals() const { return normals_; }
  std::size_t bytes() const;

 private:
  void list_corners(const Mesh& mesh);

  std::vector<Vec3> normals_;
  /// Corners (3·triangle + corner) of normal i: corners_[begin_[i]] … corners_[begin_[i+1]]. Each
  /// normal sums its own corners, so the sum does not depend on the threads.
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> corners_;
};

}  // namespace regraft::accel
