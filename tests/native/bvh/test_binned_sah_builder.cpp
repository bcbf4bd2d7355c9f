#include "regraft/bvh/binned_sah_builder.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "bvh/boxes.h"
#include "bvh/traps.h"
#include "regraft/bvh/part_few.h"
#include "regraft/bvh/sah.h"

namespace regraft::test {
namespace {

using bvh::BinnedSahBuilder;
using bvh::Bvh;

TEST(BinnedSahBuilder, NothingMakesAnEmptyTree) {
  const Bvh tree = Boxes().build();
  EXPECT_TRUE(tree.empty());
  EXPECT_EQ(tree.node_count(), 0u);
  EXPECT_TRUE(tree.bounds().empty());
}

TEST(BinnedSahBuilder, OnePrimitiveMakesOneLeaf) {
  const Boxes boxes({cube({1, 2, 3}, 0.5)});
  const Bvh tree = boxes.build();
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_EQ(tree.node_count(), 1u);
  EXPECT_TRUE(tree.nodes[0].leaf());
  EXPECT_EQ(tree.depth, 0u);
}

TEST(BinnedSahBuilder, PrimitivesThatAreNotAskedForAreLeftOut) {
  Boxes boxes = random_boxes(100, 1);
  boxes.boxes[7] = Aabb{};
  std::erase_if(boxes.ids, [](std::uint32_t id) { return id % 3 == 1; });
  const Bvh tree = boxes.build();
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_EQ(tree.prim_ids.size(), 67u);
}

TEST(FewParted, BoxesWithoutACostArePartedToo) {
  const Aabb none, nan{Vec3(NAN), Vec3(NAN)};
  for (const Aabb& b : {none, nan})
    for (std::size_t count = 2; count <= bvh::FewParted::most; ++count) {
      const bvh::PrimRef ref{{b.lo.x, b.lo.y, b.lo.z}, 0, {b.hi.x, b.hi.y, b.hi.z}, 0};
      const std::vector<bvh::PrimRef> refs(count, ref);
      EXPECT_EQ(bvh::FewParted(refs).left, 1u);
    }
}

TEST(BinnedSahBuilder, TreesAreTheSameForAnyNumberOfThreads) {
  // Large enough for the parallel binning and partition, and for many tasks.
  const Boxes boxes = random_boxes(150000, 2, 1.0, 0.02);
  const Bvh tree = boxes.build(1);
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_TRUE(tree == boxes.build(2));
  EXPECT_TRUE(tree == boxes.build(5));
}

TEST(BinnedSahBuilder, LeavesHoldNoMoreThanAllowed) {
  const Boxes boxes = random_boxes(1000, 3, 1.0, 2.0);
  for (const std::uint32_t most : {1u, 2u, 4u, 16u}) {
    BinnedSahBuilder::Config config;
    config.max_leaf = most;
    const Bvh tree = boxes.build(2, config);
    EXPECT_EQ(boxes.flaw(tree), "");
    for (std::size_t n = 0; n < tree.nodes.size(); ++n)
      EXPECT_TRUE(n == 1 || tree.nodes[n].count <= most);
  }
}

TEST(BinnedSahBuilder, TwoHeapsAreToldApartByTheFirstSplit) {
  std::vector<Aabb> all;
  for (const Aabb& b : random_boxes(50, 4).boxes) all.push_back(b);
  for (const Aabb& b : random_boxes(70, 5).boxes)
    all.push_back({b.lo + Vec3(0, 100, 0), b.hi + Vec3(0, 100, 0)});
  const Bvh tree = Boxes(all).build();
  const bvh::Node& root = tree.nodes[0];
  EXPECT_LT(tree.nodes[root.first].hi.y, 50.0f);
  EXPECT_GT(tree.nodes[root.first + 1].lo.y, 50.0f);
}

TEST(BinnedSahBuilder, CostsFarLessThanATreeThatHalvesBlindly) {
  const Boxes boxes = random_boxes(4000, 6, 1.0, 0.01);
  // 4,000 small boxes: a good tree tests about the boxes on one path and its surroundings.
  EXPECT_LT(bvh::sah_cost(boxes.build()), 60.0);
}

TEST(BinnedSahBuilder, NoInputMakesItLoopOrDive) {
  for (const Trap& trap : traps()) {
    SCOPED_TRACE(trap.name);
    const Bvh tree = trap.boxes.build(1);
    EXPECT_EQ(trap.boxes.flaw(tree), "");
    EXPECT_LE(tree.depth, bvh::max_depth);
    EXPECT_TRUE(std::isfinite(bvh::sah_cost(tree)));
    EXPECT_TRUE(tree == trap.boxes.build(5));
  }
}

TEST(BinnedSahBuilder, ALongGeometricSeriesStaysWithinTheDepth) {
  // Each split peels off few boxes: 100,000 of them would go thousands of levels deep.
  std::vector<Aabb> all;
  for (int i = 0; i < 100000; ++i) {
    const double x = std::exp2(-125.0 + 250.0 * i / 100000.0);
    all.push_back(cube({x, x, x}, x * 1e-3));
  }
  const Boxes boxes(all);
  const Bvh tree = boxes.build();
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_LE(tree.depth, bvh::max_depth);
}

RC_GTEST_PROP(BinnedSahBuilder, AnyBoxesMakeAValidTree, ()) {
  // Few coordinates: many equal centroids, flat boxes and points.
  const auto coordinate = rc::gen::inRange(-3, 4);
  const auto count = *rc::gen::inRange<std::size_t>(0, 200);
  std::vector<Aabb> all;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 lo(*coordinate, *coordinate, *coordinate);
    all.push_back({lo, lo + Vec3(*rc::gen::inRange(0, 3), 0, *rc::gen::inRange(0, 2))});
  }
  const Boxes boxes(all);
  BinnedSahBuilder::Config config;
  config.max_leaf = *rc::gen::inRange(1u, 17u);
  config.task_size = *rc::gen::inRange(1u, 50u);
  const Bvh tree = boxes.build(1, config);
  RC_ASSERT(boxes.flaw(tree) == "");
  RC_ASSERT(tree == boxes.build(5, config));
}

}  // namespace
}  // namespace regraft::test
