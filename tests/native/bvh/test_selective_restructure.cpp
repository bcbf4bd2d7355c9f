#include "regraft/bvh/selective_restructure.h"

#include <gtest/gtest.h>

#include <set>

#include "bvh/living.h"
#include "regraft/bvh/pair_refinement.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::RestructuringBenefit;

Aabb unit_cube(double x) {
  return {Vec3(float(x), 0, 0), Vec3(float(x + 1), 1, 1)};
}

std::vector<Aabb> cubes(std::initializer_list<double> at) {
  std::vector<Aabb> boxes;
  for (const double x : at) boxes.push_back(unit_cube(x));
  return boxes;
}

/// Nodes from `at` on: two pairs of leaves over primitives `prim` … `prim + 3`.
void pair_of_pairs(Bvh& tree, std::uint32_t node, std::uint32_t at, std::uint32_t prim) {
  tree.nodes[node].first = at;
  for (std::uint32_t i = 0; i < 2; ++i) tree.nodes[at + i].first = at + 2 + 2 * i;
  for (std::uint32_t i = 0; i < 4; ++i) {
    tree.nodes[at + 2 + i].first = prim + i;
    tree.nodes[at + 2 + i].count = 1;
  }
}

Bvh four() {
  Bvh tree;
  tree.nodes.resize(8, bvh::Node{});
  pair_of_pairs(tree, 0, 2, 0);
  tree.prim_ids = {0, 1, 2, 3};
  tree.depth = 2;
  return tree;
}

Bvh eight() {
  Bvh tree;
  tree.nodes.resize(16, bvh::Node{});
  tree.nodes[0].first = 2;
  pair_of_pairs(tree, 2, 4, 0);
  pair_of_pairs(tree, 3, 10, 4);
  tree.prim_ids = {0, 1, 2, 3, 4, 5, 6, 7};
  tree.depth = 3;
  return tree;
}

const auto crossed = cubes({0, 4, 1, 5});
const auto paired = cubes({0, 1, 4, 5});
const auto both_crossed = cubes({0, 4, 1, 5, 100, 104, 101, 105});
const auto both_paired = cubes({0, 1, 4, 5, 100, 101, 104, 105});

/// Example E1 of the specification, to the last digit.
void check_e1(Living& t) {
  EXPECT_DOUBLE_EQ(2 * t.tree.area(0), 26.0);
  EXPECT_DOUBLE_EQ(2 * t.tree.area(2), 22.0);
  EXPECT_DOUBLE_EQ(t.tree.cost(2), 20.0 / 11.0);
  EXPECT_DOUBLE_EQ(t.cost(), 53.0 / 13.0);
  const RestructuringBenefit metric(t.tree, t.config, 1.0);
  EXPECT_DOUBLE_EQ(metric.benefit({2, 3, 0}), 2 * 80.0 / 143.0);
  const auto result = t.restructure();
  ASSERT_EQ(result.operations.size(), 1u);
  EXPECT_GE(result.operations[0].predicted, 160.0 / 143.0) << "and what refinements add";
  EXPECT_NEAR(result.operations[0].realised, 12.0 / 13.0, 1e-12);
  EXPECT_DOUBLE_EQ(t.cost(), 41.0 / 13.0);
  EXPECT_EQ(result.nodes_rebuilt, 6u);
  EXPECT_EQ(t.tree.bvh.nodes[2].hi.x, 2.0f);
  EXPECT_EQ(t.tree.bvh.nodes[3].lo.x, 4.0f);
}

TEST(SelectiveRestructure, ExampleOneWithoutTheGate) {
  Living t(crossed, four());
  t.tree.damage = -1.0;
  check_e1(t);
}

TEST(SelectiveRestructure, ExampleOneFromAGoodPose) {
  Living t(paired, four());
  EXPECT_EQ(t.restructure().pairs_considered, 1u);
  t.move(crossed);
  check_e1(t);
}

/// Example E2: the same twice, far apart. Rays enough to make each corner worth mending, not so
/// many that it pays to build all anew.
void check_e2(Living& t) {
  EXPECT_NEAR(t.cost(), 319.0 / 213.0, 1e-12);
  t.outlook.rays = 2000;
  const auto result = t.restructure();
  EXPECT_GT(result.pairs_considered, 2u);
  ASSERT_EQ(result.operations.size(), 2u);
  EXPECT_NEAR(319.0 / 213.0 - result.operations[0].realised, 1.441315, 1e-6);
  EXPECT_NEAR(t.cost(), 295.0 / 213.0, 1e-12);
}

TEST(SelectiveRestructure, ExampleTwoWithoutTheGate) {
  Living t(both_crossed, eight());
  t.tree.damage = t.tree.unit_damage = -1.0;
  t.refit();
  check_e2(t);
}

TEST(SelectiveRestructure, ExampleTwoFromAGoodPose) {
  Living t(both_paired, eight());
  EXPECT_EQ(t.restructure().pairs_considered, 1u);
  t.move(both_crossed);
  check_e2(t);
}

TEST(SelectiveRestructure, WhatTheBudgetDoesNotCoverIsCounted) {
  // A corner in two parts costs 10·2·log2(2) = 20, one in four 80.
  for (const double budget : {30.0, 200.0}) {
    Living t(both_paired, eight());
    t.move(both_crossed);
    t.outlook.rays = 2000;
    t.outlook.budget = budget;
    const auto result = t.restructure();
    EXPECT_EQ(result.operations.size(), budget > 150.0 ? 2u : 1u);
    EXPECT_EQ(result.pairs_deferred, budget > 150.0 ? 0u : 1u);
  }
}

TEST(SelectiveRestructure, OneThreadAndManyDoTheSame) {
  const Boxes start = random_boxes(3000, 1, 1.0, 0.02);
  Living one(start), many(start);
  one.threads = 1;
  many.threads = 5;
  std::uint64_t operations = 0;
  for (std::uint64_t f = 1; f < 6; ++f) {
    std::vector<Aabb> moved = one.boxes.boxes;
    Random random(f);
    for (std::size_t i = 0; i < moved.size(); i += 3) {
      const Vec3 step(random.in_box(0.2));
      moved[i].lo += step;
      moved[i].hi += step;
    }
    operations += one.frame(moved).operations.size();
    many.frame(moved);
    EXPECT_TRUE(one.tree == many.tree);
    EXPECT_EQ(one.cost(), many.cost());
  }
  EXPECT_GT(operations, 0u);
}

TEST(SelectiveRestructure, NothingIsDoneToWhatKeepsItsShape) {
  Living t(random_boxes(2000, 2));
  for (const float scale : {4.0f, 0.125f, 1.0f}) {
    std::vector<Aabb> scaled;
    for (const Aabb& b : random_boxes(2000, 2).boxes)
      scaled.push_back({b.lo * scale, b.hi * scale});
    const auto result = t.frame(scaled);
    EXPECT_EQ(t.tree.excess(0), 0.0);
    EXPECT_EQ(result.pairs_considered, 1u);
    EXPECT_TRUE(result.operations.empty());
  }
  std::vector<Aabb> shifted;
  for (const Aabb& b : random_boxes(2000, 2).boxes)
    shifted.push_back({b.lo + Vec3(3.3f), b.hi + Vec3(3.3f)});
  EXPECT_EQ(t.frame(shifted).pairs_considered, 1u);
  EXPECT_LT(t.tree.excess(0), 1e-4 * t.cost() * t.tree.area(0));
}

TEST(SelectiveRestructure, PairsAreEachThereOnceAndNeverBelowEachOther) {
  Living t(random_boxes(500, 3, 1.0, 0.02));
  t.move(random_boxes(500, 4, 1.0, 0.02).boxes);
  const RestructuringBenefit metric(t.tree, t.config, 1e9);
  const auto pairs = bvh::refine_pairs(t.tree, metric, t.config);
  EXPECT_GT(pairs.size(), 100u);
  EXPECT_LE(pairs.size(), t.config.pair_limit);
  std::set<std::pair<std::uint32_t, std::uint32_t>> known;
  for (const bvh::NodePair& pair : pairs) {
    EXPECT_TRUE(known.insert(std::minmax(pair.a, pair.b)).second);
    EXPECT_LE(pair.total, metric.cap(pair));
    for (const auto& [above, below] : {std::pair(pair.a, pair.b), std::pair(pair.b, pair.a)})
      for (std::uint32_t n = below; n != 0; n = t.tree.parent(n)) EXPECT_NE(n, above);
    bool is_above = false;
    for (std::uint32_t n = pair.a; n != 0;) is_above |= (n = t.tree.parent(n)) == pair.ancestor;
    EXPECT_TRUE(is_above);
  }
}

TEST(SelectiveRestructure, NoOperationMakesTheTreeWorse) {
  Living t(random_boxes(2000, 5, 1.0, 0.02));
  t.outlook = {1e7, 1.0};
  std::size_t count = 0;
  for (std::uint64_t f = 1; f < 8; ++f) {
    std::vector<Aabb> moved = t.boxes.boxes;
    Random random(f);
    for (std::size_t i = f; i < moved.size(); i += 7) {
      const Vec3 step(random.in_box(0.5));
      moved[i].lo += step;
      moved[i].hi += step;
    }
    const auto result = t.frame(moved);
    count += result.operations.size();
    for (const bvh::Restructured& o : result.operations) EXPECT_GE(o.realised, -1e-9);
  }
  EXPECT_GT(count, 3u);
}

TEST(SelectiveRestructure, WhatExceedsTheBudgetWaitsForLaterFrames) {
  Living at_once(random_boxes(3000, 7, 1.0, 0.02)), spread(random_boxes(3000, 7, 1.0, 0.02));
  std::vector<Aabb> moved = at_once.boxes.boxes;
  Random random(1);
  for (Aabb& b : moved)
    if (b.lo.x > 0.4f) b = cube(Vec3d(b.lo) + random.in_box(0.1), 0.01);
  for (Living* t : {&at_once, &spread}) t->move(moved);
  const double damaged = spread.cost();
  const std::uint64_t all = at_once.restructure().nodes_rebuilt;
  spread.outlook.budget = 10.0 * 120 * std::log2(120.0);
  std::uint64_t frames = 0;
  for (std::uint64_t rebuilt = 1; rebuilt > 0; frames += rebuilt > 0) {
    rebuilt = spread.restructure().nodes_rebuilt;
    EXPECT_LT(rebuilt, all / 2);
  }
  EXPECT_GT(all, 500u);
  EXPECT_GE(frames, 2u);
  EXPECT_GT(damaged - spread.cost(), 0.3 * (damaged - at_once.cost()));
}

TEST(SelectiveRestructure, PrimitivesWithoutABoxStayAndComeBack) {
  Living t(random_boxes(1000, 6, 1.0, 0.02));
  for (std::uint64_t f = 1; f < 4; ++f) {
    std::vector<Aabb> moved = random_boxes(1000, 6 + f, 1.0, 0.02).boxes;
    for (std::size_t i = 0; i < moved.size(); i += 5) moved[i] = f == 3 ? moved[i] : Aabb{};
    t.frame(moved);
  }
}

TEST(LifeTime, IsTheFramesANodeHasLasted) {
  bvh::LifeTime life;
  EXPECT_EQ(life.frames(0), 1.0);
  life.count_built(100);
  for (int f = 0; f < 6; ++f) life.count_frame(100);
  EXPECT_EQ(life.frames(0), 6.0);
  EXPECT_EQ(life.frames(4), 4.0);
  life.count_built(200);
  EXPECT_EQ(life.frames(0), 2.0);
}

}  // namespace
}  // namespace regraft::test
