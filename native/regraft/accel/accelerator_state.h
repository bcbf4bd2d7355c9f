#pragma once

// Private to accel/: what an Accelerator holds.

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "regraft/accel/accelerator.h"
#include "regraft/accel/blas.h"
#include "regraft/accel/instance_set.h"
#include "regraft/accel/kdtree_scene.h"
#include "regraft/accel/shading_normals.h"
#include "regraft/accel/tlas.h"

namespace regraft::accel {

/// What is still to be done for a mesh's tree; kept while nobody sees the mesh.
enum class Pending : std::uint8_t { none, deformed, topology };

struct Accelerator::State {
  std::vector<Blas> blases;
  std::vector<ShadingNormals> normals;
  std::vector<Pending> pending;
  std::vector<Pending> pending_normals;
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
  TreeWork bound_meshes(const Scene& scene, std::span<const std::uint32_t> todo,
                        Executor& executor);
  void warn_of_dropped(const Scene& scene);
  void count(const Scene& scene, UpdateStatistics& statistics) const;
  void list_left_out(const Scene& scene, const ChangeSet& changes, std::size_t updated,
                     std::size_t hidden, UpdateStatistics& statistics) const;
  UpdateStatistics unchanged(const UpdateOptions& options) const;
};

}  // namespace regraft::accel
