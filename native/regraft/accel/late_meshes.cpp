#include <algorithm>

#include "regraft/accel/accelerator_state.h"

// Which meshes are brought up to date in an update, and which when rays come near.

namespace regraft::accel {

/// Whether rays that leave marks were traced since the last update.
bool Accelerator::State::rays_left_marks() const {
  return tests_done > 0 || (rays_traced > 0 && tlas.tree().was_entered());
}

/// Takes note of what rays have brought up to date since the last update.
void Accelerator::State::settle_late() {
  for (std::uint32_t id = 0; id < late.size(); ++id) {
    if (late[id] == nullptr || !late[id]->has_arrived()) continue;
    collect(*late[id]);
    late[id].reset();
    pending[id] = Pending::none;
    absences[id].end();
  }
}

void Accelerator::State::collect(LateUpdate& update) {
  if (!update.is_news()) return;
  ++untold.count;
  untold.ms += update.ms();
  untold.work.add(update.work());
}

/// Whether a changed mesh's tree may wait for rays; if so the mesh has been bounded. `is_moved`:
/// since the last update.
bool Accelerator::State::waits(const Scene& scene, std::uint32_t mesh, bool is_moved,
                               Executor& executor) {
  if (pending[mesh] != Pending::deformed || !absences[mesh].is_lasting()) return false;
  const bool is_bounded = late[mesh] != nullptr && !is_moved;
  return is_bounded || blases[mesh].postpone(scene.meshes()[mesh], executor);
}

MeshPlan Accelerator::State::plan_meshes(const Scene& scene, const ChangeSet& changes,
                                         const Waiting& waiting, Executor& executor) {
  MeshPlan plan;
  plan.changed.resize(scene.meshes().size(), 0);
  std::vector<std::uint8_t> moved(scene.meshes().size(), 0);
  for (const std::uint32_t id : changes.deformed_meshes) moved[id] = 1;
  const std::vector<std::uint8_t> seen = seen_meshes(scene);
  for (std::uint32_t id = 0; id < pending.size(); ++id) {
    if (pending[id] == Pending::none) continue;
    if (seen[id] == 0) {
      ++plan.hidden;
      late[id].reset();
      continue;
    }
    if (waiting.is_known) absences[id].note(blases[id].tree().was_entered());
    const bool was_late = late[id] != nullptr;
    const bool is_late = waiting.is_possible && waits(scene, id, moved[id] != 0, executor);
    (is_late ? plan.postpone : plan.update).push_back(id);
    if (!is_late) late[id].reset();
    plan.changed[id] = !is_late || !was_late || moved[id] != 0;
    if (pending[id] != Pending::deformed || (is_late && plan.changed[id] == 0)) continue;
    ++plan.deformed_meshes;
    plan.deformed_triangles += scene.meshes()[id].triangles.size();
  }
  return plan;
}

/// Leaves the trees of `meshes` to the rays that come near; all arguments are used while rays are
/// traced.
void Accelerator::State::postpone_meshes(const Scene& scene, std::span<const std::uint32_t> meshes,
                                         const Tending& how, Executor& executor) {
  const std::vector<double> rays = meshes.empty() ? std::vector<double>() : rays_by_mesh(scene);
  for (const std::uint32_t id : meshes) {
    Tending mine = tending_of(id, rays, how);
    mine.traced = false;
    late[id] = std::make_unique<LateUpdate>(blases[id], scene.meshes()[id], mine, executor);
  }
  if (is_linked || !meshes.empty()) instances.link(scene, late);
  is_linked = !meshes.empty();
}

void Accelerator::State::finish_late() const {
  for (const auto& update : late)
    if (update != nullptr) update->arrive();
}

bool Accelerator::State::is_behind(std::uint32_t mesh) const {
  const bool has_caught_up = late[mesh] != nullptr && late[mesh]->has_arrived();
  return pending[mesh] != Pending::none && !has_caught_up;
}

void Accelerator::count_late(UpdateStatistics& statistics) {
  State& state = *state_;
  for (const auto& update : state.late)
    if (update != nullptr) state.collect(*update);
  statistics.late_updates += state.untold.count;
  statistics.late_update_ms += state.untold.ms;
  add(state.untold.work, statistics);
  state.untold = {};
}

}  // namespace regraft::accel
