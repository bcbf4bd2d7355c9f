#include "regraft/bvh/rotate.h"

#include <gtest/gtest.h>

#include "bvh/boxes.h"
#include "bvh/trees.h"
#include "regraft/bvh/refit.h"
#include "regraft/bvh/sah.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::Rotation;

std::vector<Rotation> rotate(Bvh& tree, unsigned threads = 2) {
  return bvh::rotate(tree, {}, pool(threads));
}

/// Inner nodes at which an exchange would still save more than the pass asks for.
std::size_t not_settled(const Bvh& tree, std::uint32_t n = 0) {
  const bvh::Node& node = tree.nodes[n];
  if (node.leaf()) return 0;
  std::size_t found = 0;
  for (std::uint32_t side = 0; side < 2; ++side) {
    const bvh::Node& other = tree.nodes[node.first + 1 - side];
    found += not_settled(tree, node.first + side);
    for (std::uint32_t kept = 0; !other.leaf() && kept < 2; ++kept) {
      Aabb box = tree.nodes[node.first + side].bounds();
      box.extend(tree.nodes[other.first + kept].bounds());
      found += half_area(other.bounds()) - half_area(box) > 1e-6 * half_area(node.bounds());
    }
  }
  return found;
}

TEST(Rotate, TurnsStrangersIntoNeighbours) {
  const Boxes boxes({cube({0, 0, 0}, 0.5), cube({1, 0, 0}, 0.5), cube({4, 0, 0}, 0.5)});
  // (0, (1, 4)) is right, ((0, 4), 1) is not.
  Bvh tree = chain_tree(boxes, {1, 0, 2});
  ASSERT_EQ(boxes.flaw(tree), "");
  const std::vector<Rotation> done = rotate(tree);
  ASSERT_EQ(done.size(), 1u);
  EXPECT_EQ(done[0].node, 0u);
  EXPECT_EQ(boxes.flaw(tree), "");
  Bvh wanted = chain_tree(boxes, {2, 0, 1});
  EXPECT_DOUBLE_EQ(bvh::sah_cost(tree), bvh::sah_cost(wanted));
  EXPECT_TRUE(rotate(tree).empty());
}

TEST(Rotate, NothingIsDoneToTreesOfNoneOneAndTwoPrimitives) {
  Bvh none;
  EXPECT_TRUE(rotate(none).empty());
  for (const std::size_t count : {1, 2}) {
    const Boxes boxes = random_boxes(count, 1);
    Bvh tree = boxes.build();
    EXPECT_TRUE(rotate(tree).empty());
    EXPECT_EQ(boxes.flaw(tree), "");
  }
}

TEST(Rotate, MendsATreeThatMotionHasSpoiledAndIsTheSameForAnyNumberOfThreads) {
  for (const std::size_t count : {50, 1000, 20000}) {
    const Boxes moved = random_boxes(count, 3, 1.0, 0.02);
    Bvh spoiled = random_boxes(count, 2, 1.0, 0.02).build();
    refit_to(spoiled, moved);
    Bvh tree = spoiled;
    double cost = bvh::sah_cost(tree);
    for (int pass = 0; pass < 4; ++pass) {
      Bvh other = tree;
      const std::vector<Rotation> done = rotate(tree, 1);
      EXPECT_FALSE(done.empty());
      EXPECT_EQ(moved.flaw(tree), "");
      EXPECT_LT(bvh::sah_cost(tree), cost);
      cost = bvh::sah_cost(tree);
      EXPECT_TRUE(done == rotate(other, 5));
      EXPECT_TRUE(tree == other);
    }
    EXPECT_LT(cost, 0.95 * bvh::sah_cost(spoiled));
  }
}

TEST(Rotate, RepeatedPassesEndWhereNoExchangeSaves) {
  Boxes moved = random_boxes(300, 5);
  Bvh tree = random_boxes(300, 4).build();
  refit_to(tree, moved);
  EXPECT_GT(not_settled(tree), 0u);
  for (int pass = 0; pass < 500 && !rotate(tree).empty(); ++pass) continue;
  EXPECT_EQ(not_settled(tree), 0u);
  EXPECT_EQ(moved.flaw(tree), "");
}

TEST(Rotate, NothingIsTriedWhereTheTreeIsSettled) {
  const Boxes moved = random_boxes(2000, 7);
  Bvh tree = random_boxes(2000, 6).build();
  refit_to(tree, moved);
  for (const std::uint32_t settled : {tree.nodes[0].first, 0u}) {
    const std::vector<std::uint32_t> still = nodes_below(tree, settled);
    const bvh::RotationScope scope{[&](std::uint32_t n) { return n == settled; },
                                   [&](std::uint32_t n) { return height_of(tree, n); }};
    Bvh other = tree;
    const std::vector<Rotation> done = bvh::rotate(other, scope, pool(2));
    EXPECT_EQ(done.empty(), settled == 0);
    for (const Rotation& r : done) EXPECT_EQ(std::count(still.begin(), still.end(), r.node), 0);
    EXPECT_EQ(moved.flaw(other), "");
  }
}

TEST(Rotate, NeverMakesATreeTooDeep) {
  // A chain as deep as may be, whose boxes ask for one more exchange at every level.
  std::vector<Aabb> all;
  std::vector<std::uint32_t> order;
  Random random(8);
  for (std::uint32_t i = 0; i <= bvh::max_depth; ++i) {
    all.push_back(cube(random.in_box(1.0), 0.01));
    order.push_back(i);
  }
  const Boxes boxes(all);
  Bvh tree = chain_tree(boxes, order);
  ASSERT_EQ(tree.depth, bvh::max_depth);
  std::size_t exchanges = 0;
  for (int pass = 0; pass < 50; ++pass) {
    exchanges += rotate(tree).size();
    ASSERT_EQ(boxes.flaw(tree), "");
  }
  EXPECT_GT(exchanges, 0u);
}

TEST(Rotate, ExtremeBoxesMakeNoTrouble) {
  std::vector<std::vector<Aabb>> lists(4);
  for (int i = 0; i < 100; ++i) {
    const double x = 37 * i % 100;
    lists[0].push_back(cube({1, 1, 1}, 0.0));
    lists[1].push_back(cube({(x - 50) * 1e30, x * 1e30, 0}, 1e29));
    lists[2].push_back(cube({x * 1e-42, -x * 1e-43, 0}, 1e-44));
    lists[3].push_back(i % 3 == 0 ? Aabb{} : cube({x, 0, 0}, 0.1));
  }
  for (const std::vector<Aabb>& list : lists) {
    const Boxes boxes(list);
    Bvh tree = random_boxes(100, 9).build();
    refit_to(tree, boxes);
    for (int pass = 0; pass < 5; ++pass) {
      rotate(tree);
      EXPECT_EQ(boxes.flaw(tree), "");
    }
  }
}

}  // namespace
}  // namespace regraft::test
