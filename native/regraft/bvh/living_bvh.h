#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/bvh/refit.h"
#include "regraft/bvh/sah.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// What is kept of an inner node beside its box, so that damage is seen (Yoon, Curtis, Manocha,
/// Ray Tracing Dynamic Scenes using Selective Restructuring, EGSR 2007, section 4).
struct InnerMetrics {
  double cost = 1.0;                 ///< C, culling efficiency: Eq. 1
  double excess = 0.0;               ///< E, what was lost since the reference: Eq. 7
  double reference[2] = {0.0, 0.0};  ///< A(child)/A(node) when the node was last put in order
  std::uint32_t prims = 0;
  std::uint32_t node = 0;  ///< the inner node these are of
  std::uint32_t height = 1;
  /// Into how many subtrees in order, and primitives, the subtree falls apart; 1 if it is in order.
  std::uint32_t units = 1;
  float volume_ratio = 0.0f;  ///< V(node)/(V(left)+V(right)) at the time of the reference
};

/// A tree that is kept through many frames and, if asked, measures itself while it is refitted.
///
/// Metrics belong to inner nodes and lie where their pairs of children do: those of node n are
/// `inner[n.first / 2]`. Areas are half areas throughout; only their ratios matter.
struct LivingBvh {
  Bvh bvh;
  std::vector<InnerMetrics> inner;
  /// Whether rays entered the node above a pair since the update before: the time stamps of the
  /// paper, which need not be older than one frame. Leaves count as seen with the node above them.
  std::vector<std::uint8_t> seen;
  /// Expected tests of a ray that enters primitive i; empty: `model.leaf` each.
  std::vector<double> prim_costs;
  CostModel model;
  /// A node is damaged if its excess exceeds this share of all it costs (δ); negative: always.
  double damage = 0.05;
  /// What is to be rebuilt falls apart into subtrees whose excess is below this share.
  double unit_damage = 0.01;

  /// False: nobody asked for metrics, there are none.
  bool measured() const { return !inner.empty(); }

  double area(std::uint32_t n) const { return half_area(bvh.nodes[n].bounds()); }
  double cost(std::uint32_t n) const;
  double excess(std::uint32_t n) const;
  std::uint32_t prims(std::uint32_t n) const;
  std::uint32_t height(std::uint32_t n) const;
  std::uint32_t units(std::uint32_t n) const;
  bool damaged(std::uint32_t n) const { return excess(n) > damage * cost(n) * area(n); }
  bool in_order(std::uint32_t n) const { return !(excess(n) > unit_damage * cost(n) * area(n)); }
  double prim_cost(std::uint32_t prim) const {
    return prim_costs.empty() ? model.leaf : prim_costs[prim];
  }
  /// The node above `n`, which is not the root.
  std::uint32_t parent(std::uint32_t n) const { return inner[n >> 1].node; }
  std::uint32_t depth(std::uint32_t n) const;

  /// V(n)/(V(L)+V(R)) of inner node `n`; 0 where both children are flat.
  double volume_ratio(std::uint32_t n) const;

  /// Computes the metrics of inner node `n` from those of its children.
  void measure(std::uint32_t n);
  /// Takes the present proportions of inner node `n` for good ones.
  void set_reference(std::uint32_t n);
  /// Measures all below and including `n`, whose boxes are right, as just put in order; nothing
  /// below the nodes of `done`, which is sorted.
  void measure_anew(std::uint32_t n, std::span<const std::uint32_t> done = {});
  /// Metrics for a tree just built, all of it seen.
  void start_measuring(Executor& executor);
  void stop_measuring();
  /// Every node counts as entered by rays: at the first frame, or when none were traced.
  void see_all() { seen.assign(seen.size(), 1); }

  std::size_t bytes() const {
    return bvh.bytes() + inner.capacity() * sizeof(InnerMetrics) + seen.capacity() +
           prim_costs.capacity() * sizeof(double);
  }

  friend bool operator==(const LivingBvh& a, const LivingBvh& b) { return a.bvh == b.bvh; }

 private:
  double leaf_cost(const Node& leaf) const;
};

/// As `refit` of a `Bvh`; a measured tree measures itself in the same pass.
template <PrimitiveBounds F>
RefitResult refit(LivingBvh& tree, const F& bounds, Executor& executor) {
  if (!tree.measured()) return refit(tree.bvh, bounds, executor, tree.model);
  const RefitResult result =
      refit(tree.bvh, bounds, executor, tree.model, [&](std::uint32_t n) { tree.measure(n); });
  tree.bvh.depth = tree.height(0);
  return result;
}

}  // namespace regraft::bvh
