#include "regraft/bvh/crown.h"

#include <gtest/gtest.h>

#include "bvh/living.h"

namespace regraft::test {
namespace {

void rebuild_crown(Living& t, std::size_t parts, bvh::RestructureResult& result) {
  bvh::rebuild_crown(
      t.tree, {0, parts}, [&](std::uint32_t i) { return bvh::Box4(t.boxes.boxes[i]); }, t.builder,
      pool(t.threads), result);
  EXPECT_EQ(t.boxes.flaw(t.tree.bvh), "");
  EXPECT_EQ(t.metrics_flaw(0), "");
}

/// Clusters of ten boxes on paths of their own, through each other.
std::vector<Aabb> swarm(int frame) {
  std::vector<Aabb> boxes;
  for (std::uint64_t c = 0; c < 200; ++c) {
    Random path(c);
    const Vec3d from = path.in_box(1.0), step = path.in_box(0.05);
    for (int i = 0; i < 10; ++i) {
      const Vec3 at(from + double(frame) * step + path.in_box(0.02));
      boxes.push_back({at, at + Vec3(0.01f)});
    }
  }
  return boxes;
}

TEST(Crown, KeepsATreeOfClustersAsGoodAsNew) {
  Living t{Boxes(swarm(0))};
  double worst = 0.0;
  for (int f = 1; f < 40; ++f) {
    t.move(swarm(f));
    bvh::RestructureResult result;
    const double before = t.cost();
    rebuild_crown(t, 400, result);
    EXPECT_NEAR(before - t.cost(), result.crown_saving, 1e-9 * before);
    worst = std::max(worst, t.ratio());
  }
  EXPECT_LT(worst, 1.1);
}

TEST(Crown, NeverMakesATreeWorse) {
  for (const std::size_t parts :
       {std::size_t(2), std::size_t(3), std::size_t(50), std::size_t(5000)}) {
    Living t(random_boxes(1000, 8, 1.0, 0.02));
    for (std::uint64_t f = 1; f < 4; ++f) {
      t.move(random_boxes(1000, 8 + f % 2, 1.0, 0.02).boxes);
      bvh::RestructureResult result;
      const double before = t.cost();
      rebuild_crown(t, parts, result);
      EXPECT_LE(t.cost(), before);
      EXPECT_GE(result.crown_saving, 0.0);
    }
  }
}

TEST(Crown, TakesATreeOfOneOrTwoAsItIs) {
  for (const std::size_t count : {std::size_t(1), std::size_t(2)}) {
    Living t(random_boxes(count, 4));
    bvh::RestructureResult result;
    rebuild_crown(t, 512, result);
    EXPECT_LE(t.tree.bvh.depth, 1u);
  }
}

TEST(Crown, WhatNoRayEnteredStaysWhole) {
  Living t{Boxes(swarm(0))};
  t.move(swarm(20));
  std::fill(t.tree.seen.begin(), t.tree.seen.end(), std::uint8_t(0));
  t.tree.seen[t.tree.bvh.nodes[0].first >> 1] = 1;
  t.refit();
  bvh::RestructureResult result;
  rebuild_crown(t, 400, result);
  EXPECT_LE(result.nodes_rebuilt, 2u);
}

TEST(Crown, TheDamagedPartIsTheLowestNodeAboveWhatMoved) {
  Living t(random_boxes(2000, 3, 1.0, 0.02));
  std::vector<Aabb> moved = t.boxes.boxes;
  Random random(1);
  for (Aabb& b : moved)
    if (b.lo.x > 0.5f && b.lo.y > 0.5f) b = cube(Vec3d(b.lo) + random.in_box(0.2), 0.01);
  t.move(moved);
  const std::uint32_t part = bvh::damaged_part(t.tree);
  EXPECT_NE(part, 0u);
  EXPECT_GT(t.tree.excess(part), 0.9 * t.tree.excess(0));
  EXPECT_LT(t.tree.prims(part), 1000u);
  bvh::RestructureResult result;
  const double before = t.cost();
  bvh::rebuild_crown(
      t.tree, {part, 200}, [&](std::uint32_t i) { return bvh::Box4(t.boxes.boxes[i]); }, t.builder,
      pool(2), result);
  EXPECT_EQ(t.boxes.flaw(t.tree.bvh), "");
  EXPECT_EQ(t.metrics_flaw(0), "");
  EXPECT_GT(result.crown_saving, 0.0);
  EXPECT_NEAR(before - t.cost(), result.crown_saving, 1e-9 * before);
}

TEST(Crown, OneThreadAndManyDoTheSame) {
  Living one{Boxes(swarm(0))}, many{Boxes(swarm(0))};
  one.threads = 1;
  many.threads = 5;
  for (int f = 1; f < 10; f += 4)
    for (Living* t : {&one, &many}) {
      t->move(swarm(f));
      bvh::RestructureResult result;
      rebuild_crown(*t, 600, result);
    }
  EXPECT_TRUE(one.tree == many.tree);
}

}  // namespace
}  // namespace regraft::test
