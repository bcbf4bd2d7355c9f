#pragma once

#include <algorithm>
#include <cassert>
#include <concepts>
#include <vector>

#include "regraft/bvh/box4.h"
#include "regraft/bvh/bvh.h"
#include "regraft/bvh/sah.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// Returns the present box of a primitive; the empty box for one that cannot be hit.
template <typename F>
concept PrimitiveBounds = requires(const F& f, std::uint32_t prim_id) {
  { f(prim_id) } -> std::convertible_to<Box4>;
};

struct RefitResult {
  std::uint64_t nodes = 0;
  /// C(root) after the refit, as `sah_cost` computes it wherever areas are not zero.
  double sah_cost = 0.0;
  /// Σ area·tests over all nodes against the area of the primitives themselves (one a leaf). The
  /// root's area does not enter: while a scene flies apart its root grows as fast as everything
  /// in it, and C(root) sees no damage.
  double looseness = 0.0;

  /// How much worse the tree has become since `built`, measured right after its build.
  double wear(const RefitResult& built) const {
    return built.looseness > 0.0 ? looseness / built.looseness : 1.0;
  }
};

namespace detail {

/// Nodes whose subtrees are refitted as one task, in index order; what is above them is left.
std::vector<std::uint32_t> refit_frontier(const Bvh& bvh);

struct RefitSum {
  double cost = 0.0;
  double prim_area = 0.0;
  std::uint64_t nodes = 0;

  void add(const RefitSum& other) {
    cost += other.cost;
    prim_area += other.prim_area;
    nodes += other.nodes;
  }
};

/// `visit(n)` is called for every inner node n when its box and all below it are done.
template <PrimitiveBounds F, typename Visit>
Box4 refit_subtree(Bvh& bvh, std::uint32_t index, const F& bounds, const CostModel& model,
                   RefitSum& sum, const Visit& visit) {
  Node& node = bvh.nodes[index];
  Box4 box;
  double tests = 1.0;
  if (node.leaf()) {
    box = bounds(bvh.prim_ids[node.first]);
    sum.prim_area += half_area(box.aabb());
    for (std::uint32_t i = 1; i < node.count; ++i) box.extend(bounds(bvh.prim_ids[node.first + i]));
    tests = node.count * model.leaf;
  } else {
    box = refit_subtree(bvh, node.first, bounds, model, sum, visit);
    box.extend(refit_subtree(bvh, node.first + 1, bounds, model, sum, visit));
  }
  node.set_bounds(box.aabb());
  if (!node.leaf()) visit(index);
  sum.cost += tests * half_area(node.bounds());
  ++sum.nodes;
  return box;
}

/// What is above the `frontier`, which is sorted.
template <typename Visit>
void refit_above(Bvh& bvh, std::uint32_t index, const std::vector<std::uint32_t>& frontier,
                 RefitSum& sum, const Visit& visit) {
  if (std::binary_search(frontier.begin(), frontier.end(), index)) return;
  Node& node = bvh.nodes[index];
  refit_above(bvh, node.first, frontier, sum, visit);
  refit_above(bvh, node.first + 1, frontier, sum, visit);
  Aabb box = bvh.nodes[node.first].bounds();
  box.extend(bvh.nodes[node.first + 1].bounds());
  node.set_bounds(box);
  sum.cost += half_area(box);
  ++sum.nodes;
  visit(index);
}

RefitResult finish_refit(const Bvh& bvh, const RefitSum& sum, const CostModel& model);

}  // namespace detail

/// Recomputes every box from the leaves up, in parallel; the tree's shape stays. `visit(n)` is
/// called for every inner node n after all below it, at once for nodes that do not lie below each
/// other. The same boxes and the same cost for any number of threads.
template <PrimitiveBounds F, typename Visit>
RefitResult refit(Bvh& bvh, const F& bounds, Executor& executor, const CostModel& model,
                  const Visit& visit) {
  if (bvh.empty()) return {};
  const std::vector<std::uint32_t> frontier = detail::refit_frontier(bvh);
  std::vector<detail::RefitSum> sums(frontier.size());
  executor.parallel_for(frontier.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      detail::refit_subtree(bvh, frontier[i], bounds, model, sums[i], visit);
  });
  detail::RefitSum sum;
  for (const detail::RefitSum& s : sums) sum.add(s);
  detail::refit_above(bvh, 0, frontier, sum, visit);
  return detail::finish_refit(bvh, sum, model);
}

/// What `refit` would say of a tree just built, whose boxes are right: one pass through memory
/// instead of a walk. The same for any number of threads.
template <PrimitiveBounds F>
RefitResult assess(const Bvh& bvh, const F& bounds, Executor& executor, const CostModel& model) {
  constexpr std::size_t grain = 16384;
  if (bvh.empty()) return {};
  assert(bvh.free_pairs.empty());
  std::vector<detail::RefitSum> sums((bvh.nodes.size() + grain - 1) / grain);
  executor.parallel_for(bvh.nodes.size(), grain, [&](std::size_t begin, std::size_t end) {
    detail::RefitSum sum;
    for (std::size_t n = begin; n < end; ++n) {
      if (n == 1) continue;
      const Node& node = bvh.nodes[n];
      if (node.leaf()) sum.prim_area += half_area(Box4(bounds(bvh.prim_ids[node.first])).aabb());
      sum.cost += (node.leaf() ? node.count * model.leaf : 1.0) * half_area(node.bounds());
      ++sum.nodes;
    }
    sums[begin / grain] = sum;
  });
  for (std::size_t i = 1; i < sums.size(); ++i) sums[0].add(sums[i]);
  return detail::finish_refit(bvh, sums[0], model);
}

template <PrimitiveBounds F>
RefitResult refit(Bvh& bvh, const F& bounds, Executor& executor, const CostModel& model = {}) {
  return refit(bvh, bounds, executor, model, [](std::uint32_t) {});
}

}  // namespace regraft::bvh
