#include "regraft/bvh/morton_builder.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

#include "bvh/traps.h"
#include "regraft/bvh/radix_sort.h"
#include "regraft/bvh/sah.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::MortonBuilder;

Bvh build(const Boxes& boxes, unsigned threads, const MortonBuilder::Config& config = {}) {
  return MortonBuilder::build(boxes.boxes, boxes.ids, config, pool(threads));
}

TEST(MortonBuilder, NothingOneAndTwoPrimitivesMakeTheSmallestTrees) {
  EXPECT_TRUE(build(Boxes(), 1).empty());
  for (const std::size_t count : {1, 2, 4}) {
    const Boxes boxes = random_boxes(count, count);
    const Bvh tree = build(boxes, 2);
    EXPECT_EQ(boxes.flaw(tree), "");
    EXPECT_EQ(tree.node_count(), 1u);
    EXPECT_EQ(tree.depth, 0u);
  }
}

TEST(MortonBuilder, TreesAreTheSameForAnyNumberOfThreads) {
  for (const std::size_t count : {5, 1000, 150000}) {
    const Boxes boxes = random_boxes(count, 2, 1.0, 0.02);
    const Bvh tree = build(boxes, 1);
    EXPECT_EQ(boxes.flaw(tree), "");
    EXPECT_TRUE(tree == build(boxes, 2));
    EXPECT_TRUE(tree == build(boxes, 5));
  }
}

TEST(MortonBuilder, PrimitivesThatAreNotAskedForAreLeftOut) {
  Boxes boxes = random_boxes(100, 1);
  boxes.boxes[7] = Aabb{};
  std::erase_if(boxes.ids, [](std::uint32_t id) { return id % 3 == 1; });
  EXPECT_EQ(boxes.flaw(build(boxes, 2)), "");
}

TEST(MortonBuilder, TreesCostLittleMoreThanCarefullyBuiltOnes) {
  for (const double size : {0.001, 0.02, 0.2}) {
    const Boxes boxes = random_boxes(20000, 3, 1.0, size);
    EXPECT_LT(bvh::sah_cost(build(boxes, 2)), 1.4 * bvh::sah_cost(boxes.build()));
  }
}

TEST(MortonBuilder, NoInputMakesItDive) {
  for (const Trap& trap : traps()) {
    SCOPED_TRACE(trap.name);
    for (const std::uint32_t most : {1u, 4u, 16u}) {
      const Bvh tree = build(trap.boxes, 1, {most});
      EXPECT_EQ(trap.boxes.flaw(tree), "");
      EXPECT_TRUE(tree == build(trap.boxes, 5, {most}));
    }
  }
}

TEST(MortonBuilder, PrimitivesInOnePlaceAreHalvedByTheirPosition) {
  const Boxes boxes(std::vector<Aabb>(40000, cube({1, 2, 3}, 0.5)));
  const Bvh tree = build(boxes, 2);
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_LE(tree.depth, 16u);
  EXPECT_TRUE(std::is_sorted(tree.prim_ids.begin(), tree.prim_ids.end()));
}

RC_GTEST_PROP(MortonBuilder, AnyBoxesMakeAValidTree, ()) {
  const auto coordinate = rc::gen::inRange(-3, 4);
  const auto count = *rc::gen::inRange<std::size_t>(0, 200);
  std::vector<Aabb> all;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 lo(*coordinate, *coordinate, *coordinate);
    all.push_back({lo, lo + Vec3(*rc::gen::inRange(0, 3), 0, *rc::gen::inRange(0, 2))});
  }
  const Boxes boxes(all);
  RC_ASSERT(boxes.flaw(build(boxes, 1, {*rc::gen::inRange(1u, 17u)})) == "");
}

TEST(RadixSort, OrdersByKeyAndKeepsTheOrderOfEqualOnes) {
  Random random(4);
  // The last has a digit that is sorted by all threads together.
  for (const std::size_t count : {0, 1, 3, 1000, 200000}) {
    AlignedVector<bvh::KeyedId> items(count), scratch;
    for (std::uint32_t i = 0; i < count; ++i)
      items[i] = {i, std::uint32_t(random.below(i % 2 == 0 ? 1u << 30 : 100))};
    AlignedVector<bvh::KeyedId> wanted = items;
    std::stable_sort(wanted.begin(), wanted.end(),
                     [](const auto& a, const auto& b) { return a.key < b.key; });
    for (const unsigned threads : {1u, 5u}) {
      AlignedVector<bvh::KeyedId> sorted = items;
      bvh::radix_sort(sorted, scratch, 30, pool(threads));
      EXPECT_TRUE(sorted == wanted);
    }
  }
}

}  // namespace
}  // namespace regraft::test
