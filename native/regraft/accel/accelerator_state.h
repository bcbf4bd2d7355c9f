#pragma once

// Private to accel/: what an Accelerator holds.

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "regraft/accel/absence.h"
#include "regraft/accel/accelerator.h"
#include "regraft/accel/blas.h"
#include "regraft/accel/instance_set.h"
#include "regraft/accel/kdtree_scene.h"
#include "regraft/accel/late_update.h"
#include "regraft/accel/shading_normals.h"
#include "regraft/accel/tlas.h"

namespace regraft::accel {

/// What is still to be done for a mesh's tree; kept while nobody sees the mesh.
enum class Pending : std::uint8_t { none, deformed, topology };

/// What an update does to which mesh, by id.
struct MeshPlan {
  std::vector<std::uint32_t> update;
  std::vector<std::uint32_t> postpone;  ///< only bounded: rays have kept away
  std::size_t hidden = 0;               ///< changed, but nobody sees them
  std::vector<std::uint8_t> changed;    ///< 1: of those seen, not what it was at the last update
  std::uint64_t deformed_meshes = 0;
  std::uint64_t deformed_triangles = 0;
};

/// Whether trees may wait for rays.
struct Waiting {
  bool is_possible;  ///< rays find trees of meshes one by one
  bool is_known;     ///< what they met of late
};

/// Updates that rays have made and no statistics told of yet.
struct LateWork {
  std::uint64_t count = 0;
  double ms = 0.0;
  TreeWork work;
};

/// Adds work to what statistics tell.
void add(const TreeWork& work, UpdateStatistics& statistics);
/// What `auto` did not do, and why.
std::string reason(const TreeWork& work);

struct Accelerator::State {
  std::vector<Blas> blases;
  std::vector<ShadingNormals> normals;
  std::vector<Pending> pending;
  std::vector<Pending> pending_normals;
  std::vector<Absence> absences;
  std::vector<std::unique_ptr<LateUpdate>> late;  ///< null: the tree waits for nobody
  bool is_linked = false;                         ///< instances show some of these
  LateWork untold;
  std::vector<std::uint64_t> looked_at;  ///< the update that last asked a mesh for its rays
  InstanceSet instances;
  Tlas tlas;
  KdtreeScene kdtree;
  trace::TraceView view;
  std::vector<std::string> mesh_warnings;
  /// What the last update was asked for and said, for an update with nothing to do.
  UpdateOptions last_options;
  int last_width = 0;
  Structure structure = Structure::automatic;  ///< traced now; automatic: nothing yet
  /// Rays since the last update and what they cost, and rays of the last frame that had any; at
  /// first a guess.
  std::atomic<std::uint64_t> rays_traced{0};
  std::atomic<std::uint64_t> tests_done{0};
  double frame_rays = 262144.0;
  UpdateStatistics last;
  std::uint64_t bytes_without_kdtree = 0;
  std::uint64_t updates = 0;  ///< those that had something to do

  void note(const ChangeSet& changes, std::size_t mesh_count);
  void mark(std::uint32_t mesh, Pending what);
  void renew_trees();
  std::vector<std::uint8_t> seen_meshes(const Scene& scene) const;
  Tending tending(const UpdateOptions& options, int width);
  std::vector<double> rays_by_mesh(const Scene& scene) const;
  Tending tending_of(std::uint32_t mesh, std::span<const double> expected, const Tending& how);
  TreeWork update_meshes(const Scene& scene, std::span<const std::uint32_t> todo, Layout layout,
                         const Tending& how, Executor& executor);
  bool rays_left_marks() const;
  void settle_late();
  void collect(LateUpdate& update);
  bool waits(const Scene& scene, std::uint32_t mesh, bool is_moved, Executor& executor);
  MeshPlan plan_meshes(const Scene& scene, const ChangeSet& changes, const Waiting& waiting,
                       Executor& executor);
  void postpone_meshes(const Scene& scene, std::span<const std::uint32_t> meshes,
                       const Tending& how, Executor& executor);
  void finish_late() const;
  bool is_behind(std::uint32_t mesh) const;
  TreeWork bound_meshes(const Scene& scene, std::span<const std::uint32_t> todo,
                        Executor& executor);
  void warn_of_dropped(const Scene& scene);
  void count(const Scene& scene, UpdateStatistics& statistics) const;
  double cost_ratio() const;
  void list_left_out(const Scene& scene, const ChangeSet& changes, const MeshPlan& plan,
                     UpdateStatistics& statistics) const;
  UpdateStatistics unchanged(const UpdateOptions& options) const;
};

}  // namespace regraft::accel
