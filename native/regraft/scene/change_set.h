#pragma once

#include <cstdint>
#include <vector>

namespace regraft {

/// What changed since the last update, as ids by kind; no geometry. An id appears once a list.
struct ChangeSet {
  std::vector<std::uint32_t> added_meshes;
  std::vector<std::uint32_t> removed_meshes;
  std::vector<std::uint32_t> retopologised_meshes;
  std::vector<std::uint32_t> deformed_meshes;
  /// Instances whose matrix changed.
  std::vector<std::uint32_t> moved_instances;
  /// Instances added, removed, hidden or shown: the set that is traced changed.
  bool instance_set_changed = false;

  bool empty() const {
    return added_meshes.empty() && removed_meshes.empty() && retopologised_meshes.empty() &&
           deformed_meshes.empty() && moved_instances.empty() && !instance_set_changed;
  }
};

}  // namespace regraft
