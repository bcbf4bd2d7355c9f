#include "regraft/accel/blas.h"

#include <algorithm>
#include <atomic>

#include "regraft/accel/triangle_bounds.h"
#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/validate.h"

namespace regraft::accel {

namespace {
constexpr std::size_t grain = 16384;

std::vector<Aabb> all_bounds(const Mesh& mesh, Executor& executor) {
  std::vector<Aabb> boxes(mesh.triangles.size());
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
}  // namespace

TreeWork Blas::update(const Mesh& mesh, bool topology_changed, Policy policy, int width,
                      Executor& executor) {
  const bool topology = topology_changed || wide_.width() != width;
  const bool dead_wake = exists_ && !topology && revived(mesh);
  TreeState state{exists_, topology || dead_wake, true, wear()};
  TreeUpdate todo = choose_update(state, policy);
  TreeWork work;
  if (todo == TreeUpdate::refit) {
    now_ = refit(mesh, executor);
    work.nodes_refitted = now_.nodes;
    // The refit has just measured this frame's damage: a tree found worn out is not traced.
    state.wear = wear();
    todo = choose_update(state, policy);
    if (todo == TreeUpdate::refit) {
      wide_.refit(bvh_, executor);
      refitted_ = true;
    }
  }
  if (todo == TreeUpdate::rebuild) {
    build(mesh, width, executor);
    work.nodes_rebuilt = bvh_.node_count();
  }
  work.done = todo;
  return work;
}

void Blas::build(const Mesh& mesh, int width, Executor& executor) {
  const std::vector<Aabb> boxes = all_bounds(mesh, executor);
  const std::vector<std::uint8_t> degenerate = degenerate_flags(mesh, executor);
  std::vector<std::uint32_t> ids;
  ids.reserve(boxes.size());
  dropped_.clear();
  for (std::uint32_t t = 0; t < boxes.size(); ++t)
    (degenerate[t] == 0 ? ids : dropped_).push_back(t);
  bvh_ = bvh::BinnedSahBuilder::build(boxes, ids, {}, executor);
  wide_ = bvh::WideBvh::derive(bvh_, width, executor);
  now_ = built_ = refit(mesh, executor);
  exists_ = true;
  refitted_ = false;
}

bvh::RefitResult Blas::refit(const Mesh& mesh, Executor& executor) {
  std::atomic<std::uint32_t> lost{0};
  const auto count_lost = [&] { lost.fetch_add(1, std::memory_order_relaxed); };
  const auto bounds = [&](std::uint32_t t) { return fast_triangle_bounds(mesh, t, count_lost); };
  const bvh::RefitResult result = bvh::refit(bvh_, bounds, executor);
  extent_ = bvh_.bounds();
  non_finite_ = lost;
  zero_area_ = 0;
  for (const std::uint32_t t : dropped_) {
    const Aabb box = fast_triangle_bounds(mesh, t).aabb();
    extent_.extend(box);
    ++(box.empty() ? non_finite_ : zero_area_);
  }
  return result;
}

bool Blas::revived(const Mesh& mesh) const {
  return std::any_of(dropped_.begin(), dropped_.end(),
                     [&](std::uint32_t t) { return !is_degenerate(mesh, t); });
}

trace::MeshView Blas::view(const Mesh& mesh) const {
  trace::MeshView view;
  if (bvh_.bounds().empty()) return view;
  view.vertices = &mesh.vertices[0].x;
  view.triangles = &mesh.triangles[0].x;
  view.nodes = wide_.width() == 8 ? static_cast<const void*>(wide_.nodes<8>())
                                  : static_cast<const void*>(wide_.nodes<4>());
  view.prim_ids = bvh_.prim_ids.data();
  view.prim_count = std::uint32_t(bvh_.prim_ids.size());
  view.magnitude = extent_.magnitude();
  const Vec3d center = 0.5 * (Vec3d(extent_.lo) + Vec3d(extent_.hi));
  for (int k = 0; k < 3; ++k) view.center[k] = center[k];
  const Vec3d half = 0.5 * extent_.extents();
  view.radius = std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z);
  view.refitted = refitted_;
  return view;
}

std::size_t Blas::bytes() const {
  return bvh_.bytes() + wide_.bytes() + dropped_.capacity() * sizeof(std::uint32_t);
}

std::string Blas::validate(const Mesh& mesh) const {
  std::vector<Aabb> boxes(mesh.triangles.size());
  std::vector<std::uint32_t> ids;
  for (std::uint32_t t = 0; t < boxes.size(); ++t) {
    boxes[t] = triangle_bounds(mesh, t);
    if (!std::binary_search(dropped_.begin(), dropped_.end(), t)) ids.push_back(t);
  }
  return bvh::validate(bvh_, boxes, ids);
}

}  // namespace regraft::accel
