#include "regraft/bvh/refit.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "bvh/boxes.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::RefitResult;

RefitResult refit(Bvh& tree, const std::vector<Aabb>& boxes, unsigned threads = 2) {
  return bvh::refit(
      tree, [&](std::uint32_t i) { return bvh::Box4(boxes[i]); }, pool(threads));
}

TEST(Refit, NothingIsDoneToAnEmptyTree) {
  Bvh tree;
  EXPECT_EQ(refit(tree, {}).nodes, 0u);
  EXPECT_TRUE(tree.empty());
}

TEST(Refit, WithoutMotionTheTreeStaysAsBuilt) {
  const Boxes boxes = random_boxes(3000, 1);
  const Bvh built = boxes.build();
  Bvh tree = built;
  const RefitResult result = refit(tree, boxes.boxes);
  EXPECT_TRUE(tree == built);
  EXPECT_EQ(result.nodes, tree.node_count());
  EXPECT_NEAR(result.sah_cost, bvh::sah_cost(tree), 1e-9 * result.sah_cost);
  EXPECT_DOUBLE_EQ(result.wear(result), 1.0);
}

TEST(Refit, AFreshTreeIsAssessedAsARefitWouldForAnyNumberOfThreads) {
  EXPECT_EQ(bvh::assess(Bvh{}, [](std::uint32_t) { return bvh::Box4(); }, pool(1), {}).nodes, 0u);
  for (const std::size_t count : {1, 2, 100, 60000}) {
    const Boxes boxes = random_boxes(count, 10);
    Bvh tree = boxes.build();
    const auto bounds = [&](std::uint32_t i) { return bvh::Box4(boxes.boxes[i]); };
    const RefitResult result = bvh::assess(tree, bounds, pool(1), {});
    const RefitResult refitted = refit(tree, boxes.boxes);
    EXPECT_EQ(result.nodes, refitted.nodes);
    EXPECT_NEAR(result.sah_cost, refitted.sah_cost, 1e-12 * refitted.sah_cost);
    EXPECT_NEAR(result.wear(refitted), 1.0, 1e-12);
    EXPECT_EQ(result.looseness, bvh::assess(tree, bounds, pool(5), {}).looseness);
  }
}

TEST(Refit, BoxesAreExactlyThoseOfTheMovedPrimitivesForAnyNumberOfThreads) {
  const std::size_t sizes[] = {1, 5, 100, 3000, 20000};
  for (const std::size_t count : sizes) {
    const Bvh built = random_boxes(count, 2).build();
    const Boxes moved = random_boxes(count, 3, 100.0, 5.0);
    Bvh tree = built;
    const RefitResult one = refit(tree, moved.boxes, 1);
    EXPECT_EQ(moved.flaw(tree), "");
    for (const unsigned threads : {2u, 5u}) {
      Bvh other = built;
      const RefitResult result = refit(other, moved.boxes, threads);
      EXPECT_TRUE(other == tree);
      EXPECT_EQ(result.sah_cost, one.sah_cost);
      EXPECT_EQ(result.looseness, one.looseness);
    }
  }
}

TEST(Refit, CostIsThatOfTheMovedTree) {
  const Bvh built = random_boxes(5000, 4).build();
  const Boxes moved = random_boxes(5000, 5);
  Bvh tree = built;
  const RefitResult result = refit(tree, moved.boxes);
  EXPECT_NEAR(result.sah_cost, bvh::sah_cost(tree), 1e-9 * result.sah_cost);
  EXPECT_GT(result.sah_cost, 10 * bvh::sah_cost(moved.build()));
}

TEST(Refit, WearGrowsWithDamageButNotWithSize) {
  const Boxes boxes = random_boxes(2000, 6);
  Bvh tree = boxes.build();
  const RefitResult built = refit(tree, boxes.boxes);
  std::vector<Aabb> larger;
  for (const Aabb& b : boxes.boxes) larger.push_back({b.lo * 4.0f, b.hi * 4.0f});
  EXPECT_NEAR(refit(tree, larger).wear(built), 1.0, 1e-6);
  EXPECT_GT(refit(tree, random_boxes(2000, 7).boxes).wear(built), 3.0);
  EXPECT_NEAR(refit(tree, boxes.boxes).wear(built), 1.0, 1e-12);
}

TEST(Refit, APrimitiveWithoutABoxLeavesNoTraceAndComesBack) {
  const Boxes boxes = random_boxes(500, 8);
  const Bvh built = boxes.build();
  for (const std::size_t gone : {std::size_t(1), std::size_t(50), std::size_t(500)}) {
    Boxes some = boxes;
    for (std::size_t i = 0; i < gone; ++i) some.boxes[i] = Aabb{};
    Bvh tree = built;
    const RefitResult result = refit(tree, some.boxes);
    EXPECT_EQ(some.flaw(tree), "");
    EXPECT_TRUE(std::isfinite(result.sah_cost));
    EXPECT_TRUE(std::isfinite(result.wear(result)));
    EXPECT_EQ(tree.bounds().empty(), gone == 500);
    refit(tree, boxes.boxes);
    EXPECT_TRUE(tree == built);
  }
}

TEST(Refit, CostsAreFiniteForPointsLinesAndTheLargestFloats) {
  const Bvh built = random_boxes(300, 9).build();
  for (const double half : {0.0, 1e-40, 1e-20, 1e20, 1e38}) {
    std::vector<Aabb> boxes;
    for (int i = 0; i < 300; ++i)
      boxes.push_back(cube({half * (i % 3), half * (i % 2), 0}, half / 4));
    Bvh tree = built;
    const RefitResult result = refit(tree, boxes);
    EXPECT_TRUE(std::isfinite(result.sah_cost)) << half;
    EXPECT_GE(result.sah_cost, 1.0) << half;
    EXPECT_TRUE(std::isfinite(result.wear(result))) << half;
  }
}

RC_GTEST_PROP(Refit, AnyMotionIsFollowedExactly, ()) {
  const auto count = *rc::gen::inRange<std::size_t>(1, 150);
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  Bvh tree = random_boxes(count, seed).build();
  for (int frame = 0; frame < 3; ++frame) {
    Boxes boxes = random_boxes(count, seed + 1 + std::uint64_t(frame), 10.0, 3.0);
    const auto lost = *rc::gen::inRange<std::size_t>(0, 150);
    if (lost < count) boxes.boxes[lost] = Aabb{};
    refit(tree, boxes.boxes);
    RC_ASSERT(boxes.flaw(tree) == "");
  }
}

}  // namespace
}  // namespace regraft::test
