#pragma once

#include <cstdint>
#include <vector>

namespace regraft {

/// What changed since the last update, as ids by kind; no geometry. A mesh is in one list at most,
/// the one that says most; an id appears once a list.
struct ChangeSet {
  std::vector<std::uint32_t> added_meshes;
  std::vector<std::uint32_t> removed_meshes;
  std::vector<std::uint32_t> retopologised_meshes;
  std::vector<std::uint32_t> deformed_meshes;
  /// Visible instances, seen before, whose matrix is not the one they were last seen with.
  std::vector<std::uint32_t> moved_instances;
  /// Visible instances added or removed, or any hidden or shown: the set that is traced changed.
  bool instance_set_changed = false;

  bool empty() const {
    return added_meshes.empty() && removed_meshes.empty() && retopologised_meshes.empty() &&
           deformed_meshes.empty() && moved_instances.empty() && !instance_set_changed;
  }
};

}  // namespace regraft
