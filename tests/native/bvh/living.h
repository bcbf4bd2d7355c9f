#pragma once

#include <gtest/gtest.h>

#include "bvh/boxes.h"
#include "regraft/bvh/selective_restructure.h"

namespace regraft::test {

/// Boxes that move, with a measured tree that follows them.
struct Living {
  Boxes boxes;
  bvh::LivingBvh tree;
  /// Fixed, whatever machine the defaults were measured on.
  bvh::RestructureConfig config{10.0, 4.0, 4096};
  bvh::BinnedSahBuilder::Config builder;
  /// Rays times frames: dear enough that damage of any size is worth mending.
  bvh::Outlook outlook{1e6, 1.0};
  unsigned threads = 2;
  bvh::RefitResult now;

  explicit Living(Boxes start, bvh::BinnedSahBuilder::Config build = {})
      : boxes(std::move(start)), builder(build) {
    tree.bvh = boxes.build(threads, builder);
    tree.start_measuring(pool(2));
    now = refit();
  }
  Living(std::vector<Aabb> start, const bvh::Bvh& shape) : boxes(std::move(start)) {
    builder.max_leaf = 1;
    tree.bvh = shape;
    tree.start_measuring(pool(2));
    now = refit();
    tree.start_measuring(pool(2));
  }

  bvh::RefitResult refit() {
    return bvh::refit(
        tree, [&](std::uint32_t i) { return bvh::Box4(boxes.boxes[i]); }, pool(threads));
  }
  void move(std::vector<Aabb> to) {
    boxes.boxes = std::move(to);
    now = refit();
  }
  bvh::RestructureResult restructure() {
    bvh::RestructureResult result = bvh::restructure(
        tree, [&](std::uint32_t i) { return bvh::Box4(boxes.boxes[i]); }, outlook, config, builder,
        pool(threads));
    EXPECT_EQ(boxes.flaw(tree.bvh), "");
    EXPECT_EQ(metrics_flaw(0), "");
    return result;
  }
  /// One frame of the policy: mends, or builds anew if that is said to be no dearer.
  bvh::RestructureResult frame(std::vector<Aabb> to) {
    move(std::move(to));
    bvh::RestructureResult result = restructure();
    if (result.rebuild_instead) rebuild();
    return result;
  }
  void rebuild() {
    tree.bvh = boxes.build(threads, builder);
    tree.start_measuring(pool(2));
  }
  double cost() const { return tree.cost(0); }
  /// C(root) against that of a tree just built.
  double ratio() const {
    return bvh::sah_cost(tree.bvh) / bvh::sah_cost(boxes.build(threads, builder));
  }

  /// I3, I4 and Eq. 1 and 7 for all below `n`, computed anew; "" if the kept metrics agree.
  std::string metrics_flaw(std::uint32_t n) const {
    const bvh::Node& node = tree.bvh.nodes[n];
    if (node.leaf()) return "";
    const bvh::InnerMetrics& m = tree.inner[node.first >> 1];
    double cost = 1.0, excess = 0.0, own = 0.0;
    std::uint32_t prims = 0;
    for (std::uint32_t side = 0; side < 2; ++side) {
      const std::uint32_t c = node.first + side;
      std::string flaw = metrics_flaw(c);
      if (!flaw.empty()) return flaw;
      prims += tree.prims(c);
      const bvh::Node& child = tree.bvh.nodes[c];
      const bool seen = tree.seen[(child.leaf() ? c : child.first) >> 1] != 0;
      if (seen) cost += tree.cost(c) * hit_probability(tree.bvh.nodes[c].bounds(), node.bounds());
      const double grown = tree.area(c) * (1 - 1e-9) - m.reference[side] * tree.area(n);
      excess += tree.excess(c);
      own += grown * tree.cost(c);
    }
    excess += std::max(own, 0.0);
    const std::string who = "node " + std::to_string(n);
    if (m.node != n) return who + " does not know itself";
    if (m.prims != prims) return who + " counts other primitives than its children";
    if (std::abs(m.cost - cost) > 1e-9 * cost) return who + " has another cost";
    if (std::abs(m.excess - excess) > 1e-9 * excess) return who + " has another excess";
    return "";
  }
};

}  // namespace regraft::test
