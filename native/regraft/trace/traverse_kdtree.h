#pragma once

#include <cstdint>

#include "regraft/kdtree/kdtree.h"
#include "regraft/trace/traverse_bvh.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// Cells are entered by rays widened by four times what box tests take: cells end at triangles cut
/// by planes, so a hit must be looked for in every cell that its rounding may have moved it out of.
/// With it the tree needs no rule for rays in or parallel to a plane (numerics rule N11): they are
/// within the slack of both sides.
inline constexpr float cell_slack = 4.0f;

/// What of the tree's box decides whether a ray comes from far away, as for a mesh.
REGRAFT_INLINE MeshView as_mesh(const Aabb& box) {
  MeshView all;
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double half = 0.5 * (double(box.hi[k]) - double(box.lo[k]));
    all.center[k] = double(box.lo[k]) + half;
    squared += half * half;
  }
  all.radius = std::sqrt(squared);
  all.magnitude = box.magnitude();
  return all;
}

/// A ray in the tree's frame. Origins far away are moved to the scene, as for meshes.
REGRAFT_INLINE LocalRay make_cell_ray(const TraceView& view, const WorldRay& world) {
  LocalFrame frame;
  for (int k = 0; k < 3; ++k) {
    frame.origin[k] = world.origin[k] - view.scene_origin[k];
    frame.direction[k] = world.direction[k];
  }
  const MeshView all = as_mesh(view.kdtree->bounds());
  LocalRay ray;
  ray.t0 = 0.0;
  ray.scale = 1.0;
  ray.remapped = needs_remap(frame, all);
  if (ray.remapped) remap(frame, all, ray.t0, ray.scale);
  float direction[3];
  float largest = all.magnitude;
  for (int k = 0; k < 3; ++k) {
    ray.origin[k] = float(frame.origin[k]);
    direction[k] = float(frame.direction[k]);
    largest = std::fabs(ray.origin[k]) > largest ? std::fabs(ray.origin[k]) : largest;
  }
  set_slabs(ray, ray.origin, direction, cell_slack * largest);
  ray.t_near = world.t_near;
  return ray;
}

/// Primitives that a ray has lately tested, to leave out where cells name them again.
class Mailbox {
 public:
  /// True if the primitive was tested; from now on it has been.
  REGRAFT_INLINE bool test_and_set(kdtree::PrimRef ref) {
    kdtree::PrimRef& slot = slots_[(ref.prim ^ ref.object * 7u) % size];
    const bool seen = slot == ref;
    slot = ref;
    return seen;
  }

 private:
  static constexpr std::uint32_t size = 32;
  kdtree::PrimRef slots_[size]{};

 public:
  Mailbox() {
    for (kdtree::PrimRef& slot : slots_) slot = {0xFFFFFFFFu, 0xFFFFFFFFu};
  }
};

/// One ray through the cells it passes, in their order; builds those that nobody was in before.
///
/// A cell's interval is computed by the operations of `box_interval`, plane by plane on the way
/// down. A hit at t lies in the interval of a cell that names its triangle: at each plane, t is
/// within the near side's interval or within the far side's, and the slack covers that point and
/// triangle are not quite in one place. So a cell whose interval begins beyond the nearest hit can
/// be left out, and no hit has to be trusted less for lying outside the cell it was found in.
template <bool AnyHit>
class CellWalk {
 public:
  struct Cell {
    kdtree::Node* node;
    float near;
    float far;
  };

  CellWalk(const TraceView& view, const WorldRay& world, Nearest& nearest, Work& work)
      : CellWalk(view, world, make_top(view, world), make_cell_ray(view, world), nearest, work) {}
  /// `top`, `ray`: as `make_top` and `make_cell_ray` would have made them.
  CellWalk(const TraceView& view, const WorldRay& world, const SlabRay& top, const LocalRay& ray,
           Nearest& nearest, Work& work)
      : view_(view), world_(world), top_(top), ray_(ray), nearest_(nearest), work_(work) {}

  /// @return true if `AnyHit` and something was hit.
  bool run() {
    const Aabb& box = view_.kdtree->bounds();
    const Interval all = box_interval(ray_, &box.lo.x, &box.hi.x);
    const float start = local_start(ray_);
    const Cell root{&view_.kdtree->root(), all.near > start ? all.near : start, all.far};
    return root.near <= root.far && run(root);
  }

  bool run(Cell cell) {
    Cell stack[kdtree::deepest + 1];
    int top = 0;
    for (;;) {
      if (!(cell.near > local_limit(ray_, nearest_.t))) {
        const std::uint32_t state = descend(cell, stack, top);
        if (test_leaf(cell.node->prims, Node::prim_count(state))) return true;
      }
      if (top == 0) return false;
      cell = stack[--top];
    }
  }

 private:
  using Node = kdtree::Node;

  /// Down to the first leaf of the cell; what comes after is left on the stack.
  /// @return the leaf's state.
  REGRAFT_INLINE std::uint32_t descend(Cell& cell, Cell* stack, int& top) {
    for (;;) {
      const std::uint32_t state = cell.node->state.load(std::memory_order_acquire);
      if (!Node::is_inner(state)) {
        if (Node::is_built(state)) return state;
        view_.kdtree->expand(*cell.node);
        continue;
      }
      ++work_.nodes;
      const float plane = cell.node->split;
      const bool negative = ray_.near_plane[state] != int(state);
      Node* const first = cell.node->children + (negative ? 1 : 0);
      Node* const second = cell.node->children + (negative ? 0 : 1);
      const float begin = (plane - ray_.near_origin[state]) * ray_.inverse[state];
      const float end = (plane - ray_.far_origin[state]) * ray_.inverse[state];
      // Not a number (a ray in the plane): both sides.
      if (end < cell.near) {
        cell.node = second;
        cell.near = begin > cell.near ? begin : cell.near;
        continue;
      }
      if (!(begin > cell.far))
        stack[top++] = {second, begin > cell.near ? begin : cell.near, cell.far};
      cell.node = first;
      cell.far = end < cell.far ? end : cell.far;
    }
  }

  /// @return true if `AnyHit` and something was hit.
  REGRAFT_INLINE bool test_leaf(const kdtree::PrimRef* refs, std::uint32_t count) {
    std::uint32_t prims[batch];
    for (std::uint32_t i = 0; i < count;) {
      const std::uint32_t object = refs[i].object;
      int run = 0;
      for (; i < count && refs[i].object == object && run < batch; ++i)
        if (!mailbox_.test_and_set(refs[i])) prims[run++] = refs[i].prim;
      if (run == 0) continue;
      const InstanceView& instance = view_.instances[object];
      if (object != local_of_) {
        enters_ = make_local(world_, top_, instance, local_);
        local_of_ = object;
      }
      if (!enters_) continue;
      float limit = local_limit(local_, nearest_.t);
      if (test_prims<AnyHit>(local_, instance, prims, run, limit, nearest_, work_)) return true;
    }
    return false;
  }

  static constexpr int batch = 16;

  const TraceView& view_;
  const WorldRay& world_;
  const SlabRay top_;
  const LocalRay ray_;
  Nearest& nearest_;
  Work& work_;
  LocalRay local_;
  std::uint32_t local_of_ = 0xFFFFFFFFu;
  bool enters_ = false;
  Mailbox mailbox_;
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
