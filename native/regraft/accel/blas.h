#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "regraft/accel/update_policy.h"
#include "regraft/bvh/refit.h"
#include "regraft/bvh/wide_bvh.h"
#include "regraft/core/executor.h"
#include "regraft/scene/mesh.h"
#include "regraft/trace/trace_view.h"

namespace regraft::accel {

/// What one tree's update did.
struct TreeWork {
  TreeUpdate done = TreeUpdate::none;
  std::uint64_t nodes_refitted = 0;
  std::uint64_t nodes_rebuilt = 0;
};

/// One mesh's tree in the mesh's own frame, and the wide layout that rays traverse.
///
/// Triangles that cannot be hit are not in the tree. Should a deformation bring one of them to
/// life, the tree is built anew.
class Blas {
 public:
  /// Brings the tree in line with `mesh`. `width`: slots of the wide nodes.
  TreeWork update(const Mesh& mesh, bool topology_changed, Policy policy, int width,
                  Executor& executor);

  bool exists() const { return exists_; }
  const bvh::Bvh& bvh() const { return bvh_; }
  Aabb bounds() const { return bvh_.bounds(); }
  double sah_cost() const { return now_.sah_cost; }
  double wear() const { return now_.wear(built_); }
  /// Triangles no ray can meet: not finite, and of zero area when the tree was built.
  std::uint32_t non_finite() const { return non_finite_; }
  std::uint32_t zero_area() const { return zero_area_; }

  trace::MeshView view(const Mesh& mesh) const;
  std::size_t bytes() const;
  std::string validate(const Mesh& mesh) const;

 private:
  void build(const Mesh& mesh, int width, Executor& executor);
  bvh::RefitResult refit(const Mesh& mesh, Executor& executor);
  bool revived(const Mesh& mesh) const;

  bvh::Bvh bvh_;
  bvh::WideBvh wide_;
  std::vector<std::uint32_t> dropped_;
  std::uint32_t non_finite_ = 0;
  std::uint32_t zero_area_ = 0;
  bvh::RefitResult now_;
  bvh::RefitResult built_;
  /// Box of all finite triangles, even those left out: it depends on the mesh alone, not on when
  /// the tree was built, and so does what is decided by it.
  Aabb extent_;
  bool exists_ = false;
  bool refitted_ = false;
};

}  // namespace regraft::accel
