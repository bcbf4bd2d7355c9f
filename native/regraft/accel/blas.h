#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "regraft/accel/kept_tree.h"
#include "regraft/accel/moved_triangles.h"
#include "regraft/bvh/box4.h"
#include "regraft/core/executor.h"
#include "regraft/scene/mesh.h"
#include "regraft/trace/trace_view.h"

namespace regraft::accel {

/// One mesh's tree in the mesh's own frame, and the wide layout that rays traverse.
///
/// Triangles that cannot be hit are not in the tree. Should a deformation bring one of them to
/// life, the tree is built anew.
class Blas {
 public:
  /// Brings the tree in line with `mesh`. In the flat layout there is none, only what is known of
  /// the mesh as a whole; `done` then says rebuild if other triangles than before can be hit.
  TreeWork update(const Mesh& mesh, bool topology_changed, Layout layout, const Tending& how,
                  Executor& executor);

  /// Gives up the tree and only measures the mesh, for a structure that reads meshes by itself.
  void bound(const Mesh& mesh, Executor& executor);

  /// Only bounds the mesh, exactly as `update` would; its tree is behind until `update` is called,
  /// which takes all motion since the last time together.
  /// @return false if the tree lacks a triangle that can be hit now, or has none left: then nothing
  /// was done.
  bool postpone(const Mesh& mesh, Executor& executor);

  bool exists() const { return exists_; }
  /// Whether the last update found other triangles that can be hit than the one before.
  bool is_remade() const { return !refitted_; }
  const KeptTree& tree() const { return tree_; }
  const bvh::Bvh& bvh() const { return tree_.bvh(); }
  /// Triangles that rays can meet.
  std::span<const std::uint32_t> prims() const {
    return tree_.exists() ? tree_.bvh().prim_ids : prims_;
  }
  /// Where in `prims`, of a mesh without a tree, triangle `t` is; `invalid_id` if it is not.
  std::uint32_t place(std::uint32_t t) const;
  /// Which of its triangles the last update found moved; valid until the next.
  const Motion& motion() const { return motion_; }
  /// Box of those triangles.
  Aabb bounds() const { return bounds_; }
  double sah_cost() const { return tree_.sah_cost(); }
  double culling_efficiency() const { return tree_.culling_efficiency(); }
  double wear() const { return tree_.wear(); }
  /// Nodes and triangles that rays visited in the tree since this was last asked.
  double take_work() { return double(tree_.take_work() * trace::sample_every); }
  /// Triangles no ray can meet: not finite, and of zero area when the tree was built.
  std::uint32_t non_finite() const { return non_finite_; }
  std::uint32_t zero_area() const { return zero_area_; }

  trace::MeshView view(const Mesh& mesh) const;
  std::size_t bytes() const;
  std::string validate(const Mesh& mesh) const;

 private:
  void sort_out(const Mesh& mesh, Executor& executor);
  void build(const Mesh& mesh, const Tending& how, Executor& executor);
  void tend(const Mesh& mesh, const Tending& how, Executor& executor, TreeWork& work);
  void measure(const Mesh& mesh, Executor& executor);
  void note_bounds(const Mesh& mesh, const Aabb& bounds, std::uint32_t lost);
  bool revived(const Mesh& mesh) const;
  bool is_nothing(const Mesh& mesh) const;
  bool hangs_on_all_vertices(const Mesh& mesh);

  KeptTree tree_;
  MovedTriangles moved_;
  Motion motion_;
  std::vector<std::uint32_t> prims_;  ///< without a tree, ascending
  std::vector<bvh::Box4> run_boxes_;  ///< of runs of them
  std::vector<std::uint32_t> dropped_;
  std::optional<bool> on_all_vertices_;  ///< triangles of the tree use every vertex
  std::uint32_t lost_ = 0;               ///< of those in the tree that are not finite now
  std::uint32_t non_finite_ = 0;
  std::uint32_t zero_area_ = 0;
  Aabb bounds_;
  /// Box of all finite triangles, even those left out: it depends on the mesh alone, not on when
  /// the tree was built, and so does what is decided by it.
  Aabb extent_;
  bool exists_ = false;
  bool only_bounded_ = false;
  bool refitted_ = false;
};

}  // namespace regraft::accel
