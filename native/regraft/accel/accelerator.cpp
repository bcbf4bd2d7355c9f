#include "regraft/accel/accelerator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "regraft/accel/accelerator_state.h"
#include "regraft/accel/structure_choice.h"

namespace regraft::accel {

namespace {

/// Meshes below this are updated side by side, one thread each; larger ones one after the other,
/// all threads together.
constexpr std::size_t shared_size = 32768;

}  // namespace

Accelerator::Accelerator() : state_(std::make_unique<State>()) {}
Accelerator::~Accelerator() = default;
Accelerator::Accelerator(Accelerator&&) noexcept = default;
Accelerator& Accelerator::operator=(Accelerator&&) noexcept = default;

void Accelerator::State::mark(std::uint32_t mesh, Pending what) {
  pending[mesh] = std::max(pending[mesh], what);
  pending_normals[mesh] = std::max(pending_normals[mesh], what);
}

void Accelerator::State::note(const ChangeSet& changes, std::size_t mesh_count) {
  blases.resize(mesh_count);
  normals.resize(mesh_count);
  pending.resize(mesh_count, Pending::none);
  absences.resize(mesh_count);
  late.resize(mesh_count);
  looked_at.resize(mesh_count, updates);
  pending_normals.resize(mesh_count, Pending::none);
  for (const std::uint32_t id : changes.removed_meshes) {
    blases[id] = {};
    normals[id] = {};
    pending[id] = pending_normals[id] = Pending::none;
    absences[id] = {};
    late[id].reset();
  }
  for (const std::uint32_t id : changes.added_meshes) mark(id, Pending::topology);
  for (const std::uint32_t id : changes.retopologised_meshes) mark(id, Pending::topology);
  for (const std::uint32_t id : changes.deformed_meshes) mark(id, Pending::deformed);
}

/// Every tree is of another kind than asked for.
void Accelerator::State::renew_trees() {
  for (std::size_t id = 0; id < blases.size(); ++id)
    if (blases[id].exists()) pending[id] = Pending::topology;
}

Tending Accelerator::State::tending(const UpdateOptions& options, int width) {
  const auto tests = double(tests_done.exchange(0));
  if (const std::uint64_t rays = rays_traced.exchange(0); rays > 0) {
    // Where the camera looks at damage rays cost more than the average line that C speaks of: they
    // count for as many as would cost the same.
    frame_rays = std::fmax(double(rays), tests / std::fmax(last.culling_efficiency, 1.0));
  }
  // The flat layout's one tree does all the work.
  return {
      options.policy,      width,     frame_rays,    tests > 0.0,
      options.frames_left, ++updates, options.costs, options.layout == Layout::flat ? tests : 0.0};
}

std::vector<std::uint8_t> Accelerator::State::seen_meshes(const Scene& scene) const {
  std::vector<std::uint8_t> seen(scene.meshes().size(), 0);
  for (const Instance& instance : scene.instances())
    if (instance.alive && instance.visible) seen[instance.mesh] = 1;
  return seen;
}

/// How many of the last frame's rays are likely to have reached each mesh: those of the scene, by
/// the areas of its instances' boxes.
std::vector<double> Accelerator::State::rays_by_mesh(const Scene& scene) const {
  std::vector<double> rays(scene.meshes().size(), 0.0);
  const double whole = half_area(tlas.bounds());
  for (const trace::InstanceView& v : instances.views()) {
    if (v.instance_id >= scene.instances().size()) continue;
    const Aabb box{Vec3(v.lo[0], v.lo[1], v.lo[2]), Vec3(v.hi[0], v.hi[1], v.hi[2])};
    const double share = whole > 0.0 ? std::fmin(1.0, half_area(box) / whole) : 1.0;
    const std::uint32_t mesh = scene.instances()[v.instance_id].mesh;
    if (mesh < rays.size()) rays[mesh] += share * frame_rays;
  }
  return rays;
}

/// Tells a mesh's tree what rays did in it, a frame since it was last updated, and how many average
/// ones would have done so. Areas do not say: a backdrop makes the scene's box huge, and the share
/// of what all rays go through next to nothing. `expected`, unless empty, is for rays not seen.
Tending Accelerator::State::tending_of(std::uint32_t mesh, std::span<const double> expected,
                                       const Tending& how) {
  Tending mine = how;
  const double frames = double(how.update - std::exchange(looked_at[mesh], how.update));
  mine.work = blases[mesh].take_work() / std::fmax(frames, 1.0);
  mine.rays = expected.empty() || mine.work > 0.0
                  ? mine.work / std::fmax(blases[mesh].culling_efficiency(), 1.0)
                  : expected[mesh];
  return mine;
}

TreeWork Accelerator::State::update_meshes(const Scene& scene, std::span<const std::uint32_t> todo,
                                           Layout layout, const Tending& how, Executor& executor) {
  std::vector<TreeWork> work(todo.size());
  const std::vector<double> rays = how.traced ? std::vector<double>() : rays_by_mesh(scene);
  const auto update_one = [&](std::size_t i) {
    const std::uint32_t id = todo[i];
    const Tending mine = tending_of(id, rays, how);
    work[i] = blases[id].update(scene.meshes()[id], pending[id] == Pending::topology, layout, mine,
                                executor);
    pending[id] = Pending::none;
  };
  std::vector<std::size_t> small;
  for (std::size_t i = 0; i < todo.size(); ++i) {
    if (scene.meshes()[todo[i]].triangles.size() < shared_size)
      small.push_back(i);
    else
      update_one(i);
  }
  executor.parallel_for(small.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) update_one(small[i]);
  });
  TreeWork sum;
  for (const TreeWork& w : work) sum.add(w);
  return sum;
}

/// For the k-d tree, which reads meshes by itself.
TreeWork Accelerator::State::bound_meshes(const Scene& scene, std::span<const std::uint32_t> todo,
                                          Executor& executor) {
  for (const std::uint32_t id : todo) {
    blases[id].bound(scene.meshes()[id], executor);
    pending[id] = Pending::none;
  }
  return {};
}

UpdateStatistics Accelerator::update(const Scene& scene, const ChangeSet& changes,
                                     const UpdateOptions& options, int width, Executor& executor) {
  const auto start = std::chrono::steady_clock::now();
  State& state = *state_;
  const StructureChoice choice = choose_structure(scene, options, state.structure);
  const bool kdtree = choice.structure == Structure::kdtree;
  const bool other_trees = width != state.last_width ||
                           options.layout != state.last_options.layout ||
                           choice.structure != state.structure;
  UpdateStatistics s;
  if (changes.empty() && !other_trees) {
    s = state.unchanged(options);
    count_late(s);
    return s;
  }
  state.settle_late();
  state.note(changes, scene.meshes().size());
  if (other_trees) state.renew_trees();
  state.structure = choice.structure;
  const Waiting waiting{!kdtree && options.layout == Layout::two_level, state.rays_left_marks()};
  const Tending how = state.tending(options, width);
  const MeshPlan plan = state.plan_meshes(scene, changes, waiting, executor);
  TreeWork work = kdtree ? state.bound_meshes(scene, plan.update, executor)
                         : state.update_meshes(scene, plan.update, options.layout, how, executor);
  // Rays do not see the tree over instances beside a k-d tree: it says how large the scene is.
  const Layout layout = kdtree ? Layout::two_level : options.layout;
  InstanceSet::Changes placed =
      state.instances.update(scene, state.blases, changes, plan.changed,
                             kdtree ? Layout::flat : options.layout, how, executor);
  work.add(placed.baked);
  if (layout == Layout::flat && work.done == TreeUpdate::rebuild) placed.set_changed = true;
  work.add(state.tlas.update(scene, state.instances, placed, layout, how, executor));
  state.instances.note_bounds(state.tlas.bounds());
  state.postpone_meshes(scene, plan.postpone, how, executor);

  state.tlas.show(state.view);
  state.view.instances = state.instances.views().data();
  state.view.instance_count = std::uint32_t(state.instances.views().size());
  for (int k = 0; k < 3; ++k) state.view.scene_origin[k] = state.instances.origin()[k];
  std::uint64_t forgotten = 0;
  if (kdtree)
    forgotten =
        state.kdtree.update(scene, state.instances,
                            {placed, plan.changed, options.policy == Policy::rebuild}, executor);
  else
    state.kdtree.clear();
  state.view.kdtree = state.kdtree.tree();

  s.policy = name(options.policy);
  s.structure = name(choice.structure);
  s.layout = name(options.layout);
  s.moved_instances = changes.moved_instances.size();
  s.deformed_meshes = plan.deformed_meshes;
  s.deformed_triangles = plan.deformed_triangles;
  add(work, s);
  count_late(s);
  const bool has_looked = !plan.update.empty() || !plan.postpone.empty();
  if (has_looked || !changes.removed_meshes.empty()) state.warn_of_dropped(scene);
  s.warnings = state.mesh_warnings;
  s.warnings.insert(s.warnings.end(), state.instances.warnings().begin(),
                    state.instances.warnings().end());
  state.count(scene, s);
  state.bytes_without_kdtree = s.memory_bytes;
  if (kdtree) s.cost_ratio = 1.0;
  count_kdtree(s);
  state.list_left_out(scene, changes, plan, s);
  if (options.policy == Policy::automatic && !kdtree) s.left_out.push_back(reason(work));
  if (work.pairs_deferred != 0)
    s.left_out.push_back(std::to_string(work.pairs_deferred) +
                         " damaged pairs of nodes wait for the next update: mending takes a share "
                         "of a frame only");
  if (work.edited != 0)
    s.left_out.push_back(std::to_string(work.edited) +
                         (options.layout == Layout::flat ? " triangles" : " instances") +
                         " came or went: put into or taken out of their tree, not built anew");
  if (!choice.reason.empty()) s.left_out.push_back(choice.reason);
  if (forgotten != 0)
    s.left_out.push_back("only cells that met what moved were forgotten: " +
                         std::to_string(forgotten) + " nodes of the k-d tree");
  s.update_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  state.last_options = options;
  state.last_width = width;
  state.last = s;
  return s;
}

void Accelerator::note_rays(std::uint64_t rays, std::uint64_t nodes, std::uint64_t triangles) {
  // A wide node is opened by about half as many tests as it has slots in a binary tree.
  const std::uint64_t tests = nodes * std::uint64_t(state_->last_width) / 2 + triangles;
  state_->rays_traced.fetch_add(rays, std::memory_order_relaxed);
  state_->tests_done.fetch_add(tests, std::memory_order_relaxed);
}

const trace::TraceView& Accelerator::view() const {
  return state_->view;
}

std::pair<Vec3d, Vec3d> Accelerator::world_bounds() const {
  const Aabb box = state_->tlas.bounds();
  const Vec3d& origin = state_->instances.origin();
  return {Vec3d(box.lo) + origin, Vec3d(box.hi) + origin};
}

void Accelerator::update_shading_normals(const Scene& scene, Executor& executor) {
  State& state = *state_;
  const std::vector<std::uint8_t> seen = state.seen_meshes(scene);
  for (std::uint32_t id = 0; id < state.pending_normals.size(); ++id) {
    Pending& pending = state.pending_normals[id];
    if (pending == Pending::none || seen[id] == 0) continue;
    if (scene.meshes()[id].normal_count != 0)
      state.normals[id].update(scene.meshes()[id], pending == Pending::topology, executor);
    pending = Pending::none;
  }
}

std::span<const Vec3> Accelerator::shading_normals(std::uint32_t mesh) const {
  return state_->normals[mesh].normals();
}

}  // namespace regraft::accel
