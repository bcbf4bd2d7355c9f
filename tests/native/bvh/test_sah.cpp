#include "regraft/bvh/sah.h"

#include <gtest/gtest.h>

#include <limits>

#include "bvh/boxes.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::Node;

Aabb unit_cube_at(float x) {
  return {Vec3(x, 0, 0), Vec3(x + 1, 1, 1)};
}

/// ((0, 1), (2, 3)) over four boxes.
Bvh balanced(const std::vector<Aabb>& boxes) {
  Bvh tree;
  tree.nodes.resize(8, bvh::Node{});
  tree.prim_ids = {0, 1, 2, 3};
  tree.depth = 2;
  const auto box_of = [&](std::size_t i, std::size_t j) {
    Aabb box = boxes[i];
    box.extend(boxes[j]);
    return box;
  };
  const auto set = [&](std::size_t node, const Aabb& box, std::uint32_t first,
                       std::uint32_t count) {
    tree.nodes[node].set_bounds(box);
    tree.nodes[node].first = first;
    tree.nodes[node].count = count;
  };
  Aabb root = box_of(0, 1);
  root.extend(box_of(2, 3));
  set(0, root, 2, 0);
  set(2, box_of(0, 1), 4, 0);
  set(3, box_of(2, 3), 6, 0);
  for (std::uint32_t i = 0; i < 4; ++i) set(4 + i, boxes[i], i, 1);
  return tree;
}

TEST(Sah, CostOfFourCubesBadlyPairedIsThatOfTheWorkedExample) {
  const std::vector<Aabb> boxes{unit_cube_at(0), unit_cube_at(4), unit_cube_at(1), unit_cube_at(5)};
  const Bvh tree = balanced(boxes);
  EXPECT_EQ(Boxes(boxes).flaw(tree), "");
  EXPECT_NEAR(bvh::sah_cost(tree), 53.0 / 13.0, 1e-12);
}

TEST(Sah, CostOfThemWellPairedIsLess) {
  const Bvh tree = balanced({unit_cube_at(0), unit_cube_at(1), unit_cube_at(4), unit_cube_at(5)});
  EXPECT_NEAR(bvh::sah_cost(tree), 41.0 / 13.0, 1e-12);
}

TEST(Sah, CostOfALeafIsItsTestsAndOfNothingNothing) {
  const Boxes boxes({unit_cube_at(0), unit_cube_at(0)});
  EXPECT_EQ(bvh::sah_cost(Bvh{}), 0.0);
  EXPECT_EQ(bvh::sah_cost(boxes.build(), {2.0}), 4.0);
}

TEST(Sah, CostIsFiniteWithoutAnyAreaAndWithAllThereIs) {
  const float big = std::numeric_limits<float>::max();
  for (const float x : {0.0f, 1e-45f, 1e30f, big})
    for (const float y : {0.0f, 1.0f}) {
      const Aabb box{Vec3(-x, 0, 0), Vec3(x, y, 0)};
      const double cost = bvh::sah_cost(balanced({box, box, box, box}));
      EXPECT_GT(cost, 0.0);
      EXPECT_LE(cost, 9.0);
    }
}

TEST(Aabb, HitProbabilityIsARatioOfAreasThenOfLengthsThenOne) {
  const Aabb unit{Vec3(0), Vec3(1)};
  EXPECT_EQ(hit_probability({Vec3(0), Vec3(0.5f)}, unit), 0.25);
  EXPECT_EQ(hit_probability({Vec3(-9), Vec3(9)}, unit), 1.0);
  const Aabb line{Vec3(0), Vec3(4, 0, 0)};
  EXPECT_EQ(hit_probability({Vec3(0), Vec3(1, 0, 0)}, line), 0.25);
  const Aabb point{Vec3(3), Vec3(3)};
  EXPECT_EQ(hit_probability(point, point), 1.0);
  EXPECT_EQ(hit_probability(Aabb{}, unit), 0.0);
}

TEST(Aabb, HalfAreaNeitherOverflowsNorVanishes) {
  EXPECT_EQ(half_area({Vec3(0), Vec3(1, 2, 3)}), 11.0);
  EXPECT_EQ(half_area(Aabb{}), 0.0);
  EXPECT_GT(half_area({Vec3(0), Vec3(1e-30f)}), 0.0);
  EXPECT_TRUE(std::isfinite(half_area({Vec3(-3e38f), Vec3(3e38f)})));
}

TEST(Aabb, ExtendIgnoresNaNAndContainsIsClosed) {
  Aabb box;
  EXPECT_TRUE(box.empty());
  box.extend(Vec3(1, nan, 2));
  EXPECT_TRUE(box.empty());
  box.extend(Vec3(0, 1, 2));
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.lo, Vec3(0, 1, 2));
  EXPECT_EQ(box.hi, Vec3(1, 1, 2));
  EXPECT_TRUE(box.contains(box));
  EXPECT_TRUE(box.contains(Aabb{}));
  EXPECT_FALSE(box.contains({Vec3(0, 1, 2), Vec3(1, 1.5f, 2)}));
  EXPECT_EQ(box.magnitude(), 2.0f);
  EXPECT_EQ(Aabb{}.magnitude(), 0.0f);
}

}  // namespace
}  // namespace regraft::test
