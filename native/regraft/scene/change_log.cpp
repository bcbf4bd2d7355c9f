#include "regraft/scene/change_log.h"

#include <algorithm>
#include <utility>

namespace regraft {

void ChangeLog::note(std::uint32_t mesh, MeshMark mark) {
  if (mesh >= meshes_.size()) meshes_.resize(std::size_t(mesh) + 1, MeshMark::none);
  MeshMark& known = meshes_[mesh];
  if (known == MeshMark::none) listed_meshes_.push_back(mesh);
  known = std::max(known, mark);
}

void ChangeLog::mesh_removed(std::uint32_t mesh) {
  const bool unseen = mesh < meshes_.size() && meshes_[mesh] == MeshMark::added;
  note(mesh, unseen ? MeshMark::forgotten : MeshMark::removed);
}

void ChangeLog::list(std::uint32_t instance) {
  if ((instances_[instance] & listed) != 0) return;
  instances_[instance] |= listed;
  listed_instances_.push_back(instance);
}

void ChangeLog::instance_added(std::uint32_t instance, bool visible) {
  if (instance >= instances_.size()) instances_.resize(std::size_t(instance) + 1, 0);
  instances_[instance] = visible ? fresh : fresh | hidden;
  list(instance);
  instance_set_changed_ |= visible;
}

void ChangeLog::instance_removed(std::uint32_t instance) {
  instance_set_changed_ |= (instances_[instance] & hidden) == 0;
  instances_[instance] &= listed;
}

void ChangeLog::instance_shown(std::uint32_t instance, bool visible) {
  instances_[instance] &= static_cast<std::uint8_t>(~hidden);
  if (!visible) instances_[instance] |= hidden;
  list(instance);
  instance_set_changed_ = true;
}

void ChangeLog::instance_moved(std::uint32_t instance) {
  instances_[instance] |= moved;
  list(instance);
}

ChangeSet ChangeLog::changes() const {
  ChangeSet set;
  for (const std::uint32_t mesh : listed_meshes_) {
    switch (meshes_[mesh]) {
      case MeshMark::deformed:
        set.deformed_meshes.push_back(mesh);
        break;
      case MeshMark::retopologised:
        set.retopologised_meshes.push_back(mesh);
        break;
      case MeshMark::added:
        set.added_meshes.push_back(mesh);
        break;
      case MeshMark::removed:
        set.removed_meshes.push_back(mesh);
        break;
      case MeshMark::none:
      case MeshMark::forgotten:
        break;
    }
  }
  for (const std::uint32_t instance : listed_instances_) {
    const bool told = (instances_[instance] & (moved | fresh | hidden)) == moved;
    if (told) set.moved_instances.push_back(instance);
  }
  set.instance_set_changed = instance_set_changed_;
  return set;
}

ChangeSet ChangeLog::take() {
  ChangeSet set = changes();
  for (const std::uint32_t mesh : listed_meshes_) meshes_[mesh] = MeshMark::none;
  for (const std::uint32_t instance : listed_instances_) {
    const bool seen = (instances_[instance] & hidden) == 0;
    instances_[instance] &= static_cast<std::uint8_t>(seen ? 0 : ~listed);
  }
  listed_meshes_.clear();
  listed_instances_.clear();
  instance_set_changed_ = false;
  return set;
}

}  // namespace regraft
