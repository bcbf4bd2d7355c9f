#include "regraft/bvh/restructuring_benefit.h"

#include <algorithm>

namespace regraft::bvh {

namespace {

int longest_axis(const Aabb& box) {
  const Vec3d e = box.extents();
  return e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
}

/// Half of the four sides of the boxes' overlap that run along axis k, as a half area.
double side_area(const Aabb& a, const Aabb& b, int k) {
  Vec3d o;
  for (int axis = 0; axis < 3; ++axis)
    o[axis] = double(std::min(a.hi[axis], b.hi[axis])) - double(std::max(a.lo[axis], b.lo[axis]));
  return 0.5 * o[k] * (o[(k + 1) % 3] + o[(k + 2) % 3]);
}

/// What was lost at `n` itself, not below.
double own_excess(const LivingBvh& tree, std::uint32_t n) {
  const std::uint32_t first = tree.bvh.nodes[n].first;
  return tree.excess(n) - tree.excess(first) - tree.excess(first + 1);
}

}  // namespace

bool overlap(const Aabb& a, const Aabb& b) {
  for (int k = 0; k < 3; ++k) {
    const float lo = std::max(a.lo[k], b.lo[k]);
    const float hi = std::min(a.hi[k], b.hi[k]);
    const bool flat = a.lo[k] == a.hi[k] || b.lo[k] == b.hi[k];
    if (!(lo < hi || (lo == hi && flat))) return false;
  }
  return true;
}

RestructuringBenefit::RestructuringBenefit(const LivingBvh& tree, const RestructureConfig& config,
                                           double weight)
    : tree_(tree), config_(config), weight_(weight), root_area_(tree.area(0)) {}

double RestructuringBenefit::benefit(const NodePair& pair) const {
  if (!(root_area_ > 0.0)) return 0.0;
  const Aabb a = tree_.bvh.nodes[pair.a].bounds();
  const Aabb b = tree_.bvh.nodes[pair.b].bounds();
  if (!overlap(a, b)) return 0.0;
  const int axis = longest_axis(tree_.bvh.nodes[pair.ancestor].bounds());
  const double removed = std::min({side_area(a, b, axis), half_area(a), half_area(b)});
  return weight_ * (tree_.cost(pair.a) + tree_.cost(pair.b)) * removed / root_area_;
}

double RestructuringBenefit::rebuild_cost(std::uint32_t prims) const {
  return config_.rebuild * prims * std::log2(std::max(prims, 2u));
}

double RestructuringBenefit::cost(const NodePair& pair) const {
  return rebuild_cost(tree_.units(pair.a) + tree_.units(pair.b));
}

/// P_root(n)·(C(n) − 1); leaves have nothing below.
double RestructuringBenefit::below(std::uint32_t node) const {
  if (tree_.bvh.nodes[node].leaf()) return 0.0;
  return tree_.area(node) / root_area_ * (tree_.cost(node) - 1.0);
}

double RestructuringBenefit::potential(const NodePair& pair) const {
  if (!(root_area_ > 0.0)) return 0.0;
  double sum = 0.0;
  for (const std::uint32_t node : {pair.a, pair.b})
    if (tree_.damaged(node)) sum += below(node);
  return weight_ * sum;
}

double RestructuringBenefit::cap(const NodePair& pair) const {
  if (!(root_area_ > 0.0)) return 0.0;
  double all = 0.0;
  double lost = own_excess(tree_, pair.ancestor);
  for (const std::uint32_t node : {pair.a, pair.b}) {
    all += tree_.area(node) * std::max(tree_.cost(node) - 1.0, 0.0);
    lost += tree_.excess(node);
    for (std::uint32_t n = tree_.parent(node); n != pair.ancestor; n = tree_.parent(n))
      lost += own_excess(tree_, n);
  }
  // Without a gate there is no good pose to have lost anything since.
  return weight_ * (tree_.damage < 0.0 ? all : std::min(all, lost)) / root_area_;
}

double LifeTime::frames(std::uint32_t frames_left) const {
  const double expected = built_ > 0.0 ? std::max(nodes_ / built_, 1.0) : 1.0;
  return frames_left > 0 ? std::min(expected, double(frames_left)) : expected;
}

}  // namespace regraft::bvh
