#pragma once

#include <memory>
#include <optional>

#include "regraft/accel/node_batch.h"
#include "regraft/accel/update_policy.h"
#include "regraft/accel/update_statistics.h"
#include "regraft/core/aabb.h"
#include "regraft/core/executor.h"
#include "regraft/scene/scene.h"
#include "regraft/trace/trace_view.h"

namespace regraft::accel {

/// See `Accelerator::quality`. Costs in units of one ray/box test, for a ray that hits the scene.
struct Quality {
  double sah_cost = 0.0;
  double culling_efficiency = 0.0;
  double epo = 0.0;
  double origin_cost = 0.0;  ///< of a ray that starts in the scene; 0 of a k-d tree
  double cost_ratio = 1.0;
  std::uint32_t depth = 0;
  std::uint64_t bytes = 0;
  std::optional<double> kdtree_q;  ///< see kdtree::Statistics::quality; none without a k-d tree
};

/// Keeps the trees of a scene up to date and shows them to the tracer. Does not shade.
class Accelerator {
 public:
  Accelerator();
  ~Accelerator();
  Accelerator(Accelerator&&) noexcept;
  Accelerator& operator=(Accelerator&&) noexcept;

  /// Brings every tree in line with `scene`, given what changed since the last call. `width`:
  /// slots of the wide nodes, as the kernels want them.
  UpdateStatistics update(const Scene& scene, const ChangeSet& changes,
                          const UpdateOptions& options, int width, Executor& executor);

  /// Tells how many rays were traced, and if known what wide nodes they entered and triangles they
  /// tested: what trees are worth depends on it. From any thread.
  void note_rays(std::uint64_t rays, std::uint64_t nodes = 0, std::uint64_t triangles = 0);

  /// Valid until the next `update`.
  const trace::TraceView& view() const;

  /// Fills in what there is by now of a k-d tree, which grows while rays are traced.
  void count_kdtree(UpdateStatistics& statistics) const;

  /// Adds what rays have made up for in trees that were left behind, unless that was told already.
  void count_late(UpdateStatistics& statistics);

  /// World box of what can be hit, double; lo > hi when there is nothing.
  std::pair<Vec3d, Vec3d> world_bounds() const;

  /// Brings the shading normals of the meshes that changed since the last call up to date.
  /// Called before shading, not by `update`: queries do not need them.
  void update_shading_normals(const Scene& scene, Executor& executor);

  /// Shading normals of a mesh by normal id, object space, as of `update_shading_normals`; empty
  /// for a flat mesh.
  std::span<const Vec3> shading_normals(std::uint32_t mesh) const;

  /// How good the trees are, by the names of `regraft.Scene.quality`. `fresh`: also build every
  /// tree anew, beside the present ones, to compare with. Of a k-d tree: of all of it, so what no
  /// ray has asked for is built; of trees left behind: as they are once they have caught up.
  Quality quality(const Scene& scene, bool fresh, Executor& executor) const;

  /// The nodes `depth` levels below the root, counted through the top tree into those of meshes,
  /// once an instance, with leaves that come before; none of a k-d tree.
  NodeBatch nodes_at(std::uint32_t depth) const;
  /// The highest of the nodes that the last update made anew.
  NodeBatch rebuilt_nodes() const;

  /// For tests and studies: every tree checked, the first violation in words or "".
  std::string validate(const Scene& scene) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace regraft::accel
