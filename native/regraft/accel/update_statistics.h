#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace regraft::accel {

/// What an update did and what the trees are like after it; names as in docs/statistics.md.
struct UpdateStatistics {
  double update_ms = 0.0;
  std::string policy;
  std::string structure;
  std::string layout;
  std::uint64_t triangles = 0;  ///< seen by rays: counted once an instance
  std::uint64_t instances = 0;
  std::uint64_t moved_instances = 0;
  std::uint64_t deformed_meshes = 0;
  std::uint64_t deformed_triangles = 0;
  std::uint64_t nodes = 0;
  std::uint64_t nodes_refitted = 0;
  std::uint64_t nodes_rebuilt = 0;
  std::uint64_t pairs_considered = 0;
  std::uint64_t pairs_restructured = 0;
  /// Of each pair tried: expected tests a frame that were to be saved, and that were.
  std::vector<double> predicted_benefits;
  std::vector<double> realised_savings;
  double select_ms = 0.0;  ///< choosing pairs and restructuring them
  /// Trees brought up to date only when rays came near, and how long the threads of these took.
  std::uint64_t late_updates = 0;
  double late_update_ms = 0.0;
  double culling_efficiency = 0.0;
  double cost_ratio = 1.0;
  std::uint64_t kdtree_nodes = 0;
  double kdtree_built_fraction = 0.0;
  std::uint64_t kdtree_unbuilt_nodes = 0;
  std::uint64_t kdtree_large_leaves = 0;
  std::uint64_t memory_bytes = 0;
  std::vector<std::string> left_out;
  std::vector<std::string> warnings;

  /// Keeps what trees are like: nothing was done, and `reason` says so.
  void clear_work(std::string reason) {
    update_ms = select_ms = late_update_ms = 0.0;
    moved_instances = deformed_meshes = deformed_triangles = 0;
    nodes_refitted = nodes_rebuilt = pairs_considered = pairs_restructured = late_updates = 0;
    predicted_benefits = realised_savings = {};
    left_out = {std::move(reason)};
  }
};

}  // namespace regraft::accel
