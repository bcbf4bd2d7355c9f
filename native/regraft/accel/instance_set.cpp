#include "regraft/accel/instance_set.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <numeric>

#include "regraft/accel/late_update.h"

namespace regraft::accel {

namespace {

/// What an instance was affected by.
enum : std::uint8_t { by_nothing, by_mesh, by_matrix };

std::string label(const Scene& scene, std::uint32_t instance) {
  const std::string& name = scene.instances()[instance].name;
  return "instance " + std::to_string(instance) + (name.empty() ? "" : " '" + name + "'");
}

bool can_be_hit(const Scene& scene, std::span<const Blas> blases, std::uint32_t id) {
  const Instance& instance = scene.instances()[id];
  return instance.alive && instance.visible && instance.mesh < blases.size() &&
         scene.meshes()[instance.mesh].alive && !blases[instance.mesh].bounds().empty();
}

Placement placement(const Scene& scene, std::span<const Blas> blases, std::uint32_t id) {
  const Instance& instance = scene.instances()[id];
  return classify(instance.object_to_world, blases[instance.mesh].bounds());
}

/// Why an instance is left out, or null.
const char* complaint(Placement placement) {
  switch (placement) {
    case Placement::not_finite:
      return "its matrix is not finite";
    case Placement::too_large:
      return "beyond the range of floats";
    case Placement::no_area:
      return "scaled to a line or a point";
    case Placement::direct:
    case Placement::bake:
      break;
  }
  return nullptr;
}

bool can_be_placed(const Scene& scene, std::span<const Blas> blases, std::uint32_t id) {
  return can_be_hit(scene, blases, id) && complaint(placement(scene, blases, id)) == nullptr;
}

bool is_identity(const trace::InstanceView& view) {
  constexpr double linear[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  return std::ranges::equal(view.world_to_object, linear) &&
         std::ranges::count(view.position, 0.0) == 3;
}

void set_inverse(trace::InstanceView& view, const Mat4d& object_to_world) {
  const Mat3d inverse = glm::inverse(Mat3d(object_to_world));
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) view.world_to_object[3 * r + c] = inverse[c][r];
    view.position[r] = object_to_world[3][r];
  }
  view.identity = is_identity(view);
}

Mat4d relative(Mat4d m, const Vec3d& origin) {
  for (int r = 0; r < 3; ++r) m[3][r] -= origin[r];
  return m;
}

}  // namespace

/// True if another set of instances can be met than at the last update. `affected[i]`: the matrix
/// or the mesh of instance i changed.
bool InstanceSet::has_changed(const Scene& scene, std::span<const Blas> blases,
                              const ChangeSet& changes,
                              std::span<const std::uint8_t> affected) const {
  if (changes.instance_set_changed) return true;
  for (std::uint32_t id = 0; id < affected.size(); ++id)
    if (affected[id] != 0 &&
        can_be_placed(scene, blases, id) != std::binary_search(ids_.begin(), ids_.end(), id))
      return true;
  return false;
}

void InstanceSet::note_bounds(const Aabb& top) {
  const Vec3d extents = top.extents();
  const double size = std::fmax(extents.x, std::fmax(extents.y, extents.z));
  wandered_ = top.magnitude() > 16.0 * size;
}

/// @return whether other instances can be met than before; `new_places`: see `Changes`.
bool InstanceSet::collect(const Scene& scene, std::span<const Blas> blases,
                          std::vector<std::uint32_t>& new_places) {
  std::vector<std::uint32_t> ids;
  warnings_.clear();
  for (std::uint32_t i = 0; i < scene.instances().size(); ++i) {
    if (!can_be_hit(scene, blases, i)) continue;
    const char* problem = complaint(placement(scene, blases, i));
    if (problem == nullptr)
      ids.push_back(i);
    else
      warnings_.push_back(label(scene, i) + ": " + problem + "; left out");
  }
  if (ids == ids_) return false;
  new_places.clear();
  for (const std::uint32_t id : ids_) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), id);
    const bool is_there = place != ids.end() && *place == id;
    new_places.push_back(is_there ? std::uint32_t(place - ids.begin()) : invalid_id);
  }
  ids_ = std::move(ids);
  views_.assign(ids_.size(), {});
  frames_.assign(ids_.size(), Mat4d(1.0));
  trees_.assign(ids_.size(), nullptr);
  return true;
}

bool InstanceSet::choose_origin(const Scene& scene, std::span<const Blas> blases,
                                Executor& executor) {
  // A box of doubles: at 1e9 a float's steps are as large as a house.
  struct Box {
    Vec3d lo{std::numeric_limits<double>::infinity()};
    Vec3d hi{-std::numeric_limits<double>::infinity()};
  };
  constexpr std::size_t grain = 4096;
  std::vector<Box> boxes((ids_.size() + grain - 1) / grain);
  executor.parallel_for(ids_.size(), grain, [&](std::size_t begin, std::size_t end) {
    Box& box = boxes[begin / grain];
    for (std::size_t i = begin; i < end; ++i) {
      const Instance& instance = scene.instances()[ids_[i]];
      const Mat4d& m = instance.object_to_world;
      const Aabb local = blases[instance.mesh].bounds();
      const Vec3d half = 0.5 * local.extents();
      const Vec3d center = 0.5 * (Vec3d(local.lo) + Vec3d(local.hi));
      for (int r = 0; r < 3; ++r) {
        const double c = m[0][r] * center.x + m[1][r] * center.y + m[2][r] * center.z + m[3][r];
        const double h =
            std::fabs(m[0][r]) * half.x + std::fabs(m[1][r]) * half.y + std::fabs(m[2][r]) * half.z;
        box.lo[r] = std::fmin(box.lo[r], c - h);
        box.hi[r] = std::fmax(box.hi[r], c + h);
      }
    }
  });
  Box all;
  for (const Box& b : boxes) {
    all.lo = glm::min(all.lo, b.lo);
    all.hi = glm::max(all.hi, b.hi);
  }
  const Vec3d center = 0.5 * (all.lo + all.hi);
  const Vec3d extents = all.hi - all.lo;
  const double size = std::fmax(extents.x, std::fmax(extents.y, extents.z));
  const auto far_from = [&](const Vec3d& o) {
    const Vec3d d = center - o;
    return std::fmax(std::fabs(d.x), std::fmax(std::fabs(d.y), std::fabs(d.z))) > 16.0 * size;
  };
  Vec3d wanted(0.0);
  if (!ids_.empty() && std::isfinite(size) && size > 0.0 && far_from(Vec3d(0.0))) {
    if (!far_from(origin_)) return false;
    const double step = std::exp2(std::ceil(std::log2(size)));
    for (int k = 0; k < 3; ++k) wanted[k] = std::round(center[k] / step) * step;
  }
  if (wanted == origin_) return false;
  origin_ = wanted;
  return true;
}

/// @return whether the slack of boxes in its frame is another than before.
bool InstanceSet::place(const Scene& scene, std::size_t i) {
  const Instance& instance = scene.instances()[ids_[i]];
  trace::InstanceView& view = views_[i];
  const auto baked = baked_.find(ids_[i]);
  const Blas& blas = *trees_[i];
  view.instance_id = ids_[i];
  Mat4d object_to_world = instance.object_to_world;
  if (baked != baked_.end()) object_to_world = glm::translate(Mat4d(1.0), baked->second->center);
  const float magnitude = view.mesh.magnitude;
  view.mesh = blas.view(mesh(scene, i));
  set_inverse(view, object_to_world);
  frames_[i] = relative(object_to_world, origin_);
  const Aabb box = transform_bounds(frames_[i], blas.bounds(), view.mesh.magnitude);
  for (int k = 0; k < 3; ++k) {
    view.lo[k] = box.lo[k];
    view.hi[k] = box.hi[k];
  }
  const bool is_exact = view.identity && origin_ == Vec3d(0.0);
  return view.mesh.magnitude != magnitude && !is_exact;
}

void InstanceSet::bake(const Scene& scene, std::size_t i, bool topology_changed, Layout layout,
                       const Tending& how, Executor& executor, TreeWork& work) {
  const Instance& instance = scene.instances()[ids_[i]];
  const Mesh& source = scene.meshes()[instance.mesh];
  std::unique_ptr<Baked>& slot = baked_[ids_[i]];
  if (!slot) slot = std::make_unique<Baked>();
  slot->center = Vec3d(instance.object_to_world[3]);
  slot->mesh.vertices.resize(source.vertices.size());
  const Mat3d linear(instance.object_to_world);
  for (std::size_t v = 0; v < source.vertices.size(); ++v)
    slot->mesh.vertices[v] = Vec3(linear * Vec3d(source.vertices[v]));
  topology_changed |= slot->mesh.triangles != source.triangles;
  if (topology_changed) slot->mesh.triangles = source.triangles;
  work.add(slot->blas.update(slot->mesh, topology_changed, layout, how, executor));
}

/// The flat layout's tree holds triangles: those of a mesh that has others now are gone.
void InstanceSet::tell_remade(const Scene& scene, std::span<const std::uint8_t> changed_meshes,
                              Changes& result) const {
  const auto is_remade = [&](std::uint32_t place) {
    return changed_meshes[scene.instances()[ids_[place]].mesh] != 0 && trees_[place]->is_remade();
  };
  if (!baked_.empty()) {
    result.new_places.clear();
    return;
  }
  if (!result.set_changed) {
    result.new_places.resize(ids_.size());
    std::iota(result.new_places.begin(), result.new_places.end(), 0u);
  }
  for (std::uint32_t& place : result.new_places)
    if (place != invalid_id && is_remade(place)) place = invalid_id;
}

InstanceSet::Changes InstanceSet::update(const Scene& scene, std::span<const Blas> blases,
                                         const ChangeSet& changes,
                                         std::span<const std::uint8_t> changed_meshes,
                                         Layout layout, const Tending& how, Executor& executor) {
  Changes result;
  std::vector<std::uint8_t> affected(scene.instances().size(), 0);
  for (std::uint32_t id = 0; id < affected.size(); ++id) {
    const Instance& instance = scene.instances()[id];
    if (instance.alive && changed_meshes[instance.mesh] != 0) affected[id] = by_mesh;
  }
  for (const std::uint32_t id : changes.moved_instances) affected[id] = by_matrix;
  if (has_changed(scene, blases, changes, affected))
    result.set_changed = collect(scene, blases, result.new_places);
  if ((result.set_changed || wandered_) && choose_origin(scene, blases, executor)) {
    result.set_changed = true;
    result.new_places.clear();
  }
  const auto unbaked = std::erase_if(baked_, [&](const auto& item) {
    return !std::binary_search(ids_.begin(), ids_.end(), item.first) ||
           classify(scene.instances()[item.first].object_to_world) != Placement::bake;
  });
  result.set_changed |= unbaked != 0;
  std::vector<std::size_t> stale;
  for (std::size_t i = 0; i < ids_.size(); ++i)
    if (result.set_changed || affected[ids_[i]] != 0 || layout != layout_) stale.push_back(i);
  for (const std::size_t i : stale) {
    const Instance& instance = scene.instances()[ids_[i]];
    const bool known = baked_.contains(ids_[i]);
    if (classify(instance.object_to_world) == Placement::bake &&
        (!known || affected[ids_[i]] != 0 || layout != layout_))
      bake(scene, i, !known || layout != layout_, layout, how, executor, result.baked);
    result.set_changed |= known != baked_.contains(ids_[i]);
  }
  const bool trees_moved = result.set_changed || blases.data() != blases_;
  for (std::size_t i = 0; trees_moved && i < ids_.size(); ++i) {
    const auto baked = baked_.find(ids_[i]);
    trees_[i] =
        baked == baked_.end() ? &blases[scene.instances()[ids_[i]].mesh] : &baked->second->blas;
  }
  blases_ = blases.data();
  if (layout == Layout::flat) tell_remade(scene, changed_meshes, result);
  result.as_a_whole.resize(stale.size());
  executor.parallel_for(stale.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      result.as_a_whole[i] = place(scene, stale[i]) || affected[ids_[stale[i]]] != by_mesh;
  });
  layout_ = layout;
  result.moved = std::move(stale);
  return result;
}

void InstanceSet::link(const Scene& scene, std::span<const std::unique_ptr<LateUpdate>> late) {
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    views_[i].mesh.late = nullptr;
    const auto& update = late[scene.instances()[ids_[i]].mesh];
    // A baked instance has vertices and a tree of its own, which do not wait.
    if (update != nullptr && !baked_.contains(ids_[i])) update->show_in(views_[i]);
  }
}

const Mesh& InstanceSet::mesh(const Scene& scene, std::size_t i) const {
  const auto baked = baked_.find(ids_[i]);
  return baked == baked_.end() ? scene.meshes()[scene.instances()[ids_[i]].mesh]
                               : baked->second->mesh;
}

std::size_t InstanceSet::bytes() const {
  std::size_t sum = views_.capacity() * sizeof(trace::InstanceView) +
                    frames_.capacity() * sizeof(Mat4d) + trees_.capacity() * sizeof(const Blas*);
  for (const auto& [id, baked] : baked_) sum += baked->mesh.bytes() + baked->blas.bytes();
  return sum;
}

}  // namespace regraft::accel
