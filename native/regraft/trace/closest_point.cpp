#include "regraft/trace/closest_point.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "regraft/bvh/bvh.h"
#include "regraft/bvh/wide_bvh.h"
#include "regraft/kdtree/kdtree.h"
#include "regraft/trace/late_tree.h"
#include "regraft/trace/point_triangle.h"

namespace regraft::trace {

namespace {

using bvh::WideChild;
using bvh::WideNode;

/// Boxes count as this much nearer, relative to the coordinates at hand: more than the rounding of
/// the frames' change, which is in double.
constexpr double slack = 0x1p-44;

/// Cells of a k-d tree the same, by a few times what their builder takes for rounding.
constexpr double cell_slack = 0x1p-17;

/// A node to visit, or the primitives of a leaf, no nearer than `distance` (not squared: the
/// squares of 1e200 are no doubles).
struct Candidate {
  double distance;
  std::uint32_t child;
};

/// A stack for the depth-first walk of one tree: each level leaves at most W − 1 behind.
template <int W>
struct Stack {
  Candidate entries[(W - 1) * (bvh::max_depth + 1) + 1];
  int count = 0;
  void push(const Candidate& c) { entries[count++] = c; }
  Candidate pop() { return entries[--count]; }
};

void come_near(const InstanceView& instance) {
  if (instance.mesh.late != nullptr) instance.mesh.late->arrive();
}

double box_distance(const Vec3d& p, const Vec3d& lo, const Vec3d& hi) {
  Vec3d away;
  for (int k = 0; k < 3; ++k) away[k] = std::max({lo[k] - p[k], p[k] - hi[k], 0.0});
  return glm::length(away);
}

double largest(const Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// An instance's frame. Distances in object space are at most `stretch` times those in the world.
struct Frame {
  const InstanceView* of = nullptr;
  Mat3d to_world;
  Vec3d origin;  ///< of object space, in the world
  Vec3d p;       ///< the point, in object space
  double stretch;

  Frame() = default;
  Frame(const InstanceView& instance, const Vec3d& world) : of(&instance) {
    const double* m = instance.world_to_object;
    const Mat3d to_object(m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]);
    to_world = glm::inverse(to_object);
    origin = Vec3d(instance.position[0], instance.position[1], instance.position[2]);
    p = to_object * (world - origin);
    // The largest row sum of MᵀM bounds its largest eigenvalue, the square of the stretch: exact
    // for turns, mirrors and scales.
    const Mat3d square = glm::transpose(to_object) * to_object;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k)
      sum = std::max(sum,
                     std::fabs(square[k][0]) + std::fabs(square[k][1]) + std::fabs(square[k][2]));
    stretch = std::sqrt(sum) * (1.0 + slack);
  }
};

class Search {
 public:
  Search(const TraceView& view, const Vec3d& p, double max_distance)
      : view_(view), p_(p), limit_(max_distance) {}

  const PointHit& hit() const { return hit_; }

  void try_triangle(const Frame& frame, std::uint32_t prim) {
    const InstanceView& instance = *frame.of;
    const MeshView& mesh = instance.mesh;
    if (mesh.refitted && !has_area(mesh, prim)) return;
    Vec3d corner[3];
    for (std::size_t c = 0; c < 3; ++c) {
      const float* v = mesh.vertices + 3 * std::size_t(mesh.triangles[3 * std::size_t(prim) + c]);
      corner[c] = frame.to_world * Vec3d(v[0], v[1], v[2]) + frame.origin;
    }
    const glm::dvec2 weights = nearest_weights(p_, corner[0], corner[1], corner[2]);
    const Vec3d point =
        corner[0] + weights.x * (corner[1] - corner[0]) + weights.y * (corner[2] - corner[0]);
    const double distance = glm::length(point - p_);
    if (!std::isfinite(distance) || distance > limit_) return;
    if (distance == hit_.distance &&
        (instance.instance_id > hit_.instance_id ||
         (instance.instance_id == hit_.instance_id && prim >= hit_.prim_id)))
      return;
    limit_ = distance;
    hit_ = {distance, point, instance.instance_id, prim, float(weights.x), float(weights.y)};
  }

  template <int W>
  void top() {
    const Vec3d origin(view_.scene_origin[0], view_.scene_origin[1], view_.scene_origin[2]);
    const Vec3d p = p_ - origin;
    const double margin = slack * (largest(p_) + largest(p) + view_.magnitude);
    Frame frame;
    walk<W>(view_.top_nodes, p, 1.0, margin, [&](std::uint32_t at) {
      const std::uint32_t prim = view_.top_prims[at];
      const FlatPrim* flat = view_.flat == nullptr ? nullptr : view_.flat + prim;
      const InstanceView& instance = view_.instances[flat == nullptr ? prim : flat->instance];
      // Neighbours in the flat layout's tree are mostly of one instance.
      if (frame.of != &instance) frame = Frame(instance, p_);
      if (flat != nullptr)
        try_triangle(frame, flat->prim_id);
      else
        below<W>(frame);
    });
  }

  /// The same through the cells of a k-d tree; builds those that may hold the nearest point.
  void cells() {
    const kdtree::KdTree& tree = *view_.kdtree;
    const Vec3d p = p_ - Vec3d(view_.scene_origin[0], view_.scene_origin[1], view_.scene_origin[2]);
    const Aabb& box = tree.bounds();
    Cell cell{&tree.root(), Vec3d(0.0)};
    for (int k = 0; k < 3; ++k)
      cell.away[k] = std::max({double(box.lo[k]) - p[k], p[k] - double(box.hi[k]), 0.0});
    // Cells end at triangles cut by planes, in floats.
    const double margin = cell_slack * std::max(double(box.magnitude()), largest(p));
    Cell stack[kdtree::deepest + 1];
    int count = 0;
    for (;;) {
      if (glm::length(cell.away) - margin <= limit_) {
        cell.node = descend(tree, cell, p, stack, count);
        test_leaf(*cell.node);
      }
      if (count == 0) return;
      cell = stack[--count];
    }
  }

 private:
  /// `away`: from the point to the cell, axis by axis.
  struct Cell {
    kdtree::Node* node;
    Vec3d away;
  };

  /// The leaf of the cell that is nearest to the point; what lies beyond planes goes to the stack.
  static kdtree::Node* descend(const kdtree::KdTree& tree, const Cell& cell, const Vec3d& p,
                               Cell* stack, int& count) {
    kdtree::Node* node = cell.node;
    for (;;) {
      const std::uint32_t state = node->state.load(std::memory_order_acquire);
      if (kdtree::Node::is_inner(state)) {
        const int axis = int(state);
        const bool upper = p[axis] > double(node->split);
        Vec3d away = cell.away;
        away[axis] = std::max(away[axis], std::fabs(p[axis] - double(node->split)));
        stack[count++] = {node->children + (upper ? 0 : 1), away};
        node = node->children + (upper ? 1 : 0);
      } else if (kdtree::Node::is_built(state)) {
        return node;
      } else {
        tree.expand(*node);
      }
    }
  }

  void test_leaf(const kdtree::Node& leaf) {
    const std::uint32_t count =
        kdtree::Node::prim_count(leaf.state.load(std::memory_order_acquire));
    for (std::uint32_t i = 0; i < count; ++i) {
      const kdtree::PrimRef& ref = leaf.prims[i];
      const InstanceView& instance = view_.instances[ref.object];
      if (frame_.of != &instance) frame_ = Frame(instance, p_);
      try_triangle(frame_, ref.prim);
    }
  }

  template <int W>
  void below(const Frame& frame) {
    const InstanceView& instance = *frame.of;
    come_near(instance);
    if (instance.mesh.nodes == nullptr) return;
    const double margin = slack * (largest(frame.p) + instance.mesh.magnitude);
    walk<W>(instance.mesh.nodes, frame.p, frame.stretch, margin,
            [&](std::uint32_t at) { try_triangle(frame, instance.mesh.prim_ids[at]); });
  }

  /// Visits one tree's leaves, near ones first, as long as they may hold something as near as what
  /// is known. `stretch`, `margin`: see Frame and slack.
  template <int W, typename Leaf>
  void walk(const void* tree, const Vec3d& p, double stretch, double margin, const Leaf& leaf) {
    const auto* nodes = static_cast<const WideNode<W>*>(tree);
    Stack<W> stack;
    stack.push({0.0, 0});
    while (stack.count != 0) {
      const Candidate next = stack.pop();
      if (next.distance > limit_) continue;
      if (WideChild::is_leaf(next.child)) {
        const std::uint32_t begin = WideChild::begin(next.child);
        for (std::uint32_t i = 0; i < WideChild::count(next.child); ++i) leaf(begin + i);
      } else {
        push_children(nodes[next.child], p, stretch, margin, stack);
      }
    }
  }

  template <int W>
  void push_children(const WideNode<W>& node, const Vec3d& p, double stretch, double margin,
                     Stack<W>& stack) const {
    const int first = stack.count;
    for (int i = 0; i < W && node.child[i] != WideChild::none; ++i) {
      const Vec3d lo(node.bounds[0][i], node.bounds[1][i], node.bounds[2][i]);
      const Vec3d hi(node.bounds[3][i], node.bounds[4][i], node.bounds[5][i]);
      const double distance = (box_distance(p, lo, hi) - margin) / stretch;
      if (distance <= limit_) stack.push({distance, node.child[i]});
    }
    std::sort(stack.entries + first, stack.entries + stack.count,
              [](const Candidate& a, const Candidate& b) { return a.distance > b.distance; });
  }

  const TraceView& view_;
  Vec3d p_;
  double limit_;
  PointHit hit_;
  Frame frame_;
};

bool usable(const Vec3d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

PointHit closest_point(const TraceView& view, const Vec3d& p, double max_distance) {
  Search search(view, p, max_distance);
  if (view.top_nodes == nullptr || !usable(p)) return search.hit();
  if (view.kdtree != nullptr)
    search.cells();
  else if (view.width == 8)
    search.top<8>();
  else
    search.top<4>();
  return search.hit();
}

PointHit closest_point_brute_force(const TraceView& view, const Vec3d& p, double max_distance) {
  Search search(view, p, max_distance);
  if (!usable(p)) return search.hit();
  for (std::uint32_t i = 0; i < view.instance_count; ++i) {
    const InstanceView& instance = view.instances[i];
    const Frame frame(instance, p);
    come_near(instance);
    const std::uint32_t* prims = instance.mesh.prim_ids;
    for (std::uint32_t k = 0; k < instance.mesh.prim_count; ++k)
      search.try_triangle(frame, prims == nullptr ? k : prims[k]);
  }
  return search.hit();
}

}  // namespace regraft::trace
