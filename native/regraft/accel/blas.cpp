#include "regraft/accel/blas.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "regraft/accel/key_boxes.h"
#include "regraft/accel/triangle_bounds.h"
#include "regraft/accel/vertex_bounds.h"
#include "regraft/bvh/validate.h"

namespace regraft::accel {

namespace {
constexpr std::size_t grain = 16384;
/// Triangles that are bounded together where there is no tree.
constexpr std::size_t run_length = 512;

AlignedVector<Aabb> all_bounds(const Mesh& mesh, Executor& executor) {
  AlignedVector<Aabb> boxes(mesh.triangles.size());
  executor.parallel_for(boxes.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      boxes[t] = fast_triangle_bounds(mesh, std::uint32_t(t)).aabb();
  });
  return boxes;
}

std::vector<std::uint8_t> degenerate_flags(const Mesh& mesh, Executor& executor) {
  std::vector<std::uint8_t> flags(mesh.triangles.size());
  executor.parallel_for(flags.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) flags[t] = is_degenerate(mesh, std::uint32_t(t));
  });
  return flags;
}
struct TriangleBounds {
  Aabb box;
  std::uint32_t lost;  ///< triangles that are not finite
};

/// Box of `count` triangles; `prim(i)` is the number of the i-th.
template <typename Prim>
TriangleBounds bounds_of(const Mesh& mesh, std::size_t count, const Prim& prim,
                         Executor& executor) {
  std::vector<Aabb> boxes((count + grain - 1) / grain);
  std::atomic<std::uint32_t> lost{0};
  const auto count_lost = [&] { lost.fetch_add(1, std::memory_order_relaxed); };
  executor.parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    bvh::Box4 box;
    for (std::size_t i = begin; i < end; ++i)
      box.extend(fast_triangle_bounds(mesh, prim(i), count_lost));
    boxes[begin / grain] = box.aabb();
  });
  Aabb all;
  for (const Aabb& box : boxes) all.extend(box);
  return {all, lost};
}

}  // namespace

TreeWork Blas::update(const Mesh& mesh, bool topology_changed, Layout layout, const Tending& how,
                      Executor& executor) {
  const bool other_prims = !exists_ || only_bounded_ || topology_changed || revived(mesh);
  if (other_prims) moved_.reset(mesh);
  motion_ = other_prims ? Motion{} : moved_.take(mesh, executor);
  // Who is lost is only counted, not listed: some were, so all are looked at.
  if (lost_ != 0) motion_ = {};
  TreeWork work;
  if (layout == Layout::flat) {
    tree_ = {};
    work.done = other_prims ? TreeUpdate::rebuild : TreeUpdate::refit;
    if (other_prims || prims_.empty()) sort_out(mesh, executor);
    measure(mesh, executor);
  } else {
    work.done = tree_.choose(other_prims, true, how);
    if (work.done != TreeUpdate::rebuild) tend(mesh, how, executor, work);
    if (work.done == TreeUpdate::rebuild) {
      build(mesh, how, executor);
      work.nodes_rebuilt = bvh().node_count();
    }
  }
  exists_ = true;
  only_bounded_ = false;
  refitted_ = work.done != TreeUpdate::rebuild;
  return work;
}

/// Tells triangles that can be hit from those that cannot.
void Blas::sort_out(const Mesh& mesh, Executor& executor) {
  const std::vector<std::uint8_t> degenerate = degenerate_flags(mesh, executor);
  prims_.resize(degenerate.size());
  dropped_.clear();
  on_all_vertices_.reset();
  run_boxes_ = {};
  if (std::find(degenerate.begin(), degenerate.end(), 1) == degenerate.end())
    return std::iota(prims_.begin(), prims_.end(), 0u);
  prims_.clear();
  for (std::uint32_t t = 0; t < degenerate.size(); ++t)
    (degenerate[t] == 0 ? prims_ : dropped_).push_back(t);
}

std::uint32_t Blas::place(std::uint32_t t) const {
  const auto before = std::lower_bound(dropped_.begin(), dropped_.end(), t);
  if (before != dropped_.end() && *before == t) return invalid_id;
  return t - std::uint32_t(before - dropped_.begin());
}

void Blas::bound(const Mesh& mesh, Executor& executor) {
  *this = {};
  const TriangleBounds all = bounds_of(
      mesh, mesh.triangles.size(), [](std::size_t i) { return std::uint32_t(i); }, executor);
  bounds_ = extent_ = all.box;
  non_finite_ = all.lost;
  only_bounded_ = true;
  exists_ = true;
}

bool Blas::postpone(const Mesh& mesh, Executor& executor) {
  if (!tree_.exists() || revived(mesh) || is_nothing(mesh)) return false;
  std::optional<Aabb> box;
  if (hangs_on_all_vertices(mesh)) box = vertex_bounds(mesh.vertices, executor);
  if (box) {
    note_bounds(mesh, *box, 0);
    return true;
  }
  const std::span<const std::uint32_t> prims = this->prims();
  const TriangleBounds all = bounds_of(
      mesh, prims.size(), [&](std::size_t i) { return prims[i]; }, executor);
  note_bounds(mesh, all.box, all.lost);
  return true;
}

/// Whether no triangle of the tree can be hit: an update may then leave no tree at all.
bool Blas::is_nothing(const Mesh& mesh) const {
  const std::span<const std::uint32_t> prims = this->prims();
  return std::all_of(prims.begin(), prims.end(),
                     [&](std::uint32_t t) { return is_degenerate(mesh, t); });
}

/// Whether the box of its triangles is that of the mesh's vertices.
bool Blas::hangs_on_all_vertices(const Mesh& mesh) {
  if (on_all_vertices_) return *on_all_vertices_;
  std::vector<std::uint8_t> is_used(mesh.vertices.size(), 0);
  for (const std::uint32_t t : prims())
    for (int k = 0; k < 3; ++k) is_used[mesh.triangles[t][k]] = 1;
  on_all_vertices_ = std::find(is_used.begin(), is_used.end(), 0) == is_used.end();
  return *on_all_vertices_;
}

void Blas::build(const Mesh& mesh, const Tending& how, Executor& executor) {
  sort_out(mesh, executor);
  const AlignedVector<Aabb> boxes = all_bounds(mesh, executor);
  KeyBoxes keys;
  if (how.policy == Policy::shot) keys = key_boxes(mesh, executor);
  tree_.build({boxes, prims_, {}, keys}, how, executor);
  prims_ = {};
  note_bounds(mesh, tree_.bounds(), 0);
}

void Blas::tend(const Mesh& mesh, const Tending& how, Executor& executor, TreeWork& work) {
  std::atomic<std::uint32_t> lost{0};
  const auto count_lost = [&] { lost.fetch_add(1, std::memory_order_relaxed); };
  tree_.refit([&](std::uint32_t t) { return fast_triangle_bounds(mesh, t, count_lost); }, motion_,
              how, executor);
  tree_.mend([&](std::uint32_t t) { return fast_triangle_bounds(mesh, t); }, {}, how, executor,
             work);
  note_bounds(mesh, tree_.bounds(), lost);
}

/// Bounds a mesh without a tree: of runs of triangles those in which one moved.
void Blas::measure(const Mesh& mesh, Executor& executor) {
  std::vector<std::uint32_t> stale;
  if (motion_.all || run_boxes_.empty()) {
    run_boxes_.resize((prims_.size() + run_length - 1) / run_length);
    stale.resize(run_boxes_.size());
    std::iota(stale.begin(), stale.end(), 0u);
  }
  for (const std::uint32_t t : motion_.prims)
    if (const std::uint32_t i = place(t); i != invalid_id) stale.push_back(i / run_length);
  std::sort(stale.begin(), stale.end());
  stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
  std::atomic<std::uint32_t> lost{0};
  const auto count_lost = [&] { lost.fetch_add(1, std::memory_order_relaxed); };
  executor.parallel_for(stale.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = stale[i] * run_length;
      bvh::Box4 box;
      for (std::size_t p = first; p < std::min(first + run_length, prims_.size()); ++p)
        box.extend(fast_triangle_bounds(mesh, prims_[p], count_lost));
      run_boxes_[stale[i]] = box;
    }
  });
  bvh::Box4 all;
  for (const bvh::Box4& box : run_boxes_) all.extend(box);
  note_bounds(mesh, all.aabb(), lost);
}

void Blas::note_bounds(const Mesh& mesh, const Aabb& bounds, std::uint32_t lost) {
  bounds_ = extent_ = bounds;
  lost_ = non_finite_ = lost;
  zero_area_ = 0;
  for (const std::uint32_t t : dropped_) {
    const Aabb box = fast_triangle_bounds(mesh, t).aabb();
    extent_.extend(box);
    ++(box.empty() ? non_finite_ : zero_area_);
  }
}

bool Blas::revived(const Mesh& mesh) const {
  return std::any_of(dropped_.begin(), dropped_.end(),
                     [&](std::uint32_t t) { return !is_degenerate(mesh, t); });
}

trace::MeshView Blas::view(const Mesh& mesh) const {
  trace::MeshView view;
  if (bounds_.empty()) return view;
  view.vertices = &mesh.vertices[0].x;
  view.triangles = &mesh.triangles[0].x;
  view.nodes = tree_.exists() ? tree_.wide_nodes() : nullptr;
  view.entered = tree_.entered();
  view.work = tree_.work();
  view.prim_ids = only_bounded_ ? nullptr : prims().data();
  view.prim_count = std::uint32_t(only_bounded_ ? mesh.triangles.size() : prims().size());
  view.magnitude = extent_.magnitude();
  const Vec3d center = 0.5 * (Vec3d(extent_.lo) + Vec3d(extent_.hi));
  for (int k = 0; k < 3; ++k) view.center[k] = center[k];
  const Vec3d half = 0.5 * extent_.extents();
  view.radius = std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z);
  view.refitted = refitted_ || only_bounded_;
  return view;
}

std::size_t Blas::bytes() const {
  return tree_.bytes() + moved_.bytes() + run_boxes_.capacity() * sizeof(bvh::Box4) +
         (prims_.capacity() + dropped_.capacity()) * sizeof(std::uint32_t);
}

std::string Blas::validate(const Mesh& mesh) const {
  if (!tree_.exists()) return "";
  std::vector<Aabb> boxes(mesh.triangles.size());
  std::vector<std::uint32_t> ids;
  for (std::uint32_t t = 0; t < boxes.size(); ++t) {
    boxes[t] = triangle_bounds(mesh, t);
    if (!std::binary_search(dropped_.begin(), dropped_.end(), t)) ids.push_back(t);
  }
  return bvh::validate(tree_.bvh(), boxes, ids);
}

}  // namespace regraft::accel
