#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "regraft/bvh/living_bvh.h"
#include "regraft/bvh/refit.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// Refits a tree only above what moved, and measures only that: time grows with the number of
/// primitives that moved, not with the tree.
///
/// Keeps links upwards and, for every pair of children, what is summed up below it, so that C(root)
/// and wear come out without a look at the rest. What is to be done is touched first; then `run`
/// does it. The tree's root is no leaf.
class LocalRefit {
 public:
  /// Takes in the links of a tree of any shape. Nothing is summed up yet. O(nodes).
  void link(const Bvh& bvh, Executor& executor);
  /// Takes in that each of `nodes` holds something else than before, and touches them.
  void relink(const Bvh& bvh, std::span<const std::uint32_t> nodes);
  /// The tree has been refitted by others: all is touched when it is next to be done here.
  void forget_sums() { is_summed_ = false; }

  bool linked() const { return !above_.empty(); }
  bool summed() const { return is_summed_; }

  /// Everything is to be done.
  void touch_all();
  /// The boxes of these primitives have changed; nothing is done for one that is in no leaf.
  void touch_prims(std::span<const std::uint32_t> prims, Executor& executor);
  /// Metrics of the node above a pair are to be taken anew.
  void touch_pair(std::uint32_t pair);

  /// Recomputes the boxes of what was touched and of all above it, and measures it if the tree is
  /// measured. The same for any number of threads. `nodes` of the result: those recomputed.
  template <PrimitiveBounds F>
  RefitResult run(LivingBvh& tree, const F& bounds, Executor& executor) {
    const std::vector<std::uint32_t> tasks = frontier(tree.bvh);
    std::vector<Part> parts(tasks.size() + 1);
    executor.parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) visit(tree, tasks[i], bounds, parts[i]);
    });
    visit(tree, 0, bounds, parts.back());
    return finish(tree, parts);
  }

  /// The pairs, by their number, of all nodes that `run` looked at, and so of all above each; none
  /// where it was everything.
  std::span<const std::uint32_t> touched() const { return touched_; }
  bool touched_all() const { return touched_all_; }
  std::size_t bytes() const;

 private:
  static constexpr std::uint32_t none = 0xFFFFFFFFu;
  /// Marks of a pair: what is to be done at its first node, its second, and the node above.
  enum : std::uint8_t { first_child = 1, second_child = 2, own = 4 };

  /// Sums over all below a pair of children, they themselves included.
  struct Below {
    double tests = 0.0;      ///< Σ area·tests
    double prim_area = 0.0;  ///< as in `RefitResult::looseness`
  };
  /// What one task did.
  struct Part {
    std::uint64_t nodes = 0;
    std::vector<std::uint32_t> pairs;
  };

  void resize(const Bvh& bvh);
  void connect(const Bvh& bvh, std::uint32_t node);
  void climb(std::uint32_t node);
  std::vector<std::uint32_t> frontier(const Bvh& bvh) const;
  RefitResult finish(const LivingBvh& tree, const std::vector<Part>& parts);

  /// Refits a leaf, if asked to; returns the area of its first primitive.
  template <PrimitiveBounds F>
  static double prim_area(Bvh& bvh, Node& leaf, bool is_touched, const F& bounds) {
    Box4 box = bounds(bvh.prim_ids[leaf.first]);
    const double area = half_area(box.aabb());
    if (!is_touched) return area;
    for (std::uint32_t i = 1; i < leaf.count; ++i) box.extend(bounds(bvh.prim_ids[leaf.first + i]));
    leaf.set_bounds(box.aabb());
    return area;
  }

  template <PrimitiveBounds F>
  void visit(LivingBvh& tree, std::uint32_t n, const F& bounds, Part& part) {
    const std::uint32_t first = tree.bvh.nodes[n].first;
    const std::uint8_t mark = std::exchange(marks_[first >> 1], std::uint8_t(0));
    if (mark == 0) return;
    Below sum;
    Aabb box;
    for (std::uint32_t side = 0; side < 2; ++side) {
      Node& child = tree.bvh.nodes[first + side];
      const bool is_touched = (mark & (first_child << side)) != 0;
      double tests = 1.0;
      if (child.leaf()) {
        sum.prim_area += prim_area(tree.bvh, child, is_touched, bounds);
        tests = child.count * tree.model.leaf;
        part.nodes += is_touched;
      } else {
        if (is_touched) visit(tree, first + side, bounds, part);
        const Below& below = below_[child.first >> 1];
        sum.prim_area += below.prim_area;
        sum.tests += below.tests;
      }
      sum.tests += tests * half_area(child.bounds());
      box.extend(child.bounds());
    }
    below_[first >> 1] = sum;
    tree.bvh.nodes[n].set_bounds(box);
    if (tree.measured()) tree.measure(n);
    ++part.nodes;
    part.pairs.push_back(first >> 1);
  }

  std::vector<std::uint32_t> leaf_of_;  ///< by primitive
  std::vector<std::uint32_t> above_;    ///< by pair: the node whose children they are
  std::vector<std::uint8_t> marks_;     ///< by pair
  std::vector<Below> below_;            ///< by pair
  std::vector<std::uint32_t> touched_;
  bool is_summed_ = false;
  bool touched_all_ = false;
};

}  // namespace regraft::bvh
