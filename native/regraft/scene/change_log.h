#pragma once

#include <cstdint>
#include <vector>

#include "regraft/scene/change_set.h"

namespace regraft {

/// What has happened to meshes and instances since the changes were last taken. Keeps one mark
/// an id, so that an id ends up in at most one of the mesh lists and at most once in any list.
class ChangeLog {
 public:
  void mesh_added(std::uint32_t mesh) { note(mesh, MeshMark::added); }
  void mesh_retopologised(std::uint32_t mesh) { note(mesh, MeshMark::retopologised); }
  void mesh_deformed(std::uint32_t mesh) { note(mesh, MeshMark::deformed); }
  /// A mesh that was added since the last `take` is forgotten: nobody has seen it.
  void mesh_removed(std::uint32_t mesh);

  void instance_added(std::uint32_t instance, bool visible);
  void instance_removed(std::uint32_t instance);
  void instance_shown(std::uint32_t instance, bool visible);
  /// The move of a hidden instance is kept back until it is shown; that of a new one is nothing
  /// to tell, since nobody has seen its old matrix.
  void instance_moved(std::uint32_t instance);

  ChangeSet changes() const;
  ChangeSet take();

 private:
  /// In rising precedence, but for `forgotten`.
  enum class MeshMark : std::uint8_t { none, deformed, retopologised, added, removed, forgotten };
  /// Bits of an instance's mark. A hidden one keeps its mark beyond `take`.
  enum : std::uint8_t { listed = 1, moved = 2, fresh = 4, hidden = 8 };

  void note(std::uint32_t mesh, MeshMark mark);
  void list(std::uint32_t instance);

  std::vector<MeshMark> meshes_;
  std::vector<std::uint8_t> instances_;
  std::vector<std::uint32_t> listed_meshes_;
  std::vector<std::uint32_t> listed_instances_;
  bool instance_set_changed_ = false;
};

}  // namespace regraft
