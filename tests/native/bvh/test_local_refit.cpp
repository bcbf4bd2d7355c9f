#include "regraft/bvh/local_refit.h"

#include <gtest/gtest.h>

#include "bvh/living.h"

namespace regraft::test {
namespace {

using bvh::LocalRefit;
using bvh::RefitResult;

/// A tree that is refitted where it moved, beside one that is refitted whole.
struct Followed {
  Living part;
  Living whole;
  LocalRefit local;

  explicit Followed(std::size_t count)
      : part(random_boxes(count, 1)), whole(random_boxes(count, 1)) {
    local.link(part.tree.bvh, pool(part.threads));
    local.touch_all();
    follow({});
  }

  /// Moves `count` boxes, next to each other by number or anywhere.
  std::vector<std::uint32_t> move(std::size_t count, bool anywhere, Random& random) {
    std::vector<std::uint32_t> moved;
    const std::size_t all = part.boxes.boxes.size();
    const std::size_t first = random.below(all - count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t prim = anywhere ? random.below(all) : first + i;
      part.boxes.boxes[prim] = cube(random.in_box(1.2), random.uniform(0.0, 0.1));
      moved.push_back(std::uint32_t(prim));
    }
    return moved;
  }

  RefitResult follow(const std::vector<std::uint32_t>& moved) {
    local.touch_prims(moved, pool(part.threads));
    part.now = local.run(
        part.tree, [&](std::uint32_t i) { return bvh::Box4(part.boxes.boxes[i]); },
        pool(part.threads));
    whole.move(part.boxes.boxes);
    return part.now;
  }

  void expect_equal() const {
    EXPECT_TRUE(part.tree.bvh == whole.tree.bvh);
    EXPECT_EQ(part.metrics_flaw(0), "");
    EXPECT_EQ(part.cost(), whole.cost());
    EXPECT_EQ(part.tree.excess(0), whole.tree.excess(0));
    EXPECT_NEAR(part.now.sah_cost, whole.now.sah_cost, 1e-9 * whole.now.sah_cost);
    EXPECT_NEAR(part.now.looseness, whole.now.looseness, 1e-9 * whole.now.looseness);
  }
};

TEST(LocalRefit, LeavesWhatARefitOfAllWould) {
  for (const std::size_t count : {40, 3000}) {
    Followed t(count);
    t.expect_equal();
    Random random(7);
    for (int frame = 0; frame < 12; ++frame) {
      t.follow(t.move(1 + count / 30, frame % 2 == 0, random));
      t.expect_equal();
    }
  }
}

TEST(LocalRefit, LooksAtNothingButTheWayToWhatMoved) {
  Followed t(3000);
  EXPECT_EQ(t.follow({}).nodes, 0u);
  t.part.boxes.boxes[17] = cube({0, 0, 0}, 0.2);
  const RefitResult one = t.follow({17});
  EXPECT_GT(one.nodes, 1u);
  EXPECT_LE(one.nodes, t.part.tree.bvh.depth + 1u);
  EXPECT_EQ(t.local.touched().size(), one.nodes - 1) << "the leaf has no children";
  t.expect_equal();
}

TEST(LocalRefit, LosesNothingToWhatWasFarAwayForAFrame) {
  Followed t(1000);
  const std::vector<Aabb> before = t.part.boxes.boxes;
  const RefitResult at_first = t.part.now;
  for (const Aabb& away : {cube(Vec3d(1e20), 1e10), cube(Vec3d(-1e30), 1e30), Aabb{}}) {
    t.part.boxes.boxes[5] = away;
    t.follow({5});
    t.expect_equal();
    t.part.boxes.boxes[5] = before[5];
    const RefitResult back = t.follow({5});
    EXPECT_EQ(back.sah_cost, at_first.sah_cost);
    EXPECT_EQ(back.looseness, at_first.looseness);
  }
}

TEST(LocalRefit, OneThreadAndManyDoTheSame) {
  Followed one(3000), many(3000);
  one.part.threads = 1;
  many.part.threads = 5;
  for (std::uint64_t frame = 0; frame < 4; ++frame) {
    Random random(frame), again(frame);
    one.follow(one.move(300, true, random));
    many.follow(many.move(300, true, again));
    EXPECT_TRUE(one.part.tree == many.part.tree);
    EXPECT_EQ(one.part.now.sah_cost, many.part.now.sah_cost);
    EXPECT_EQ(one.part.now.looseness, many.part.now.looseness);
    EXPECT_EQ(one.part.now.nodes, many.part.now.nodes);
  }
}

TEST(LocalRefit, FollowsATreeThatIsMended) {
  Followed t(3000);
  std::size_t operations = 0;
  Random random(3);
  for (int frame = 0; frame < 10; ++frame) {
    t.follow(t.move(200, false, random));
    const bvh::RestructureResult result = t.part.restructure();
    operations += result.operations.size();
    t.local.relink(t.part.tree.bvh, result.replaced);
    t.whole.tree = t.part.tree;
    t.expect_equal();
  }
  EXPECT_GT(operations, 0u);
}

TEST(LocalRefit, TakesMetricsAnewWhereRaysSawSomethingElse) {
  Followed t(1000);
  for (const std::uint32_t pair : {3u, 40u, 41u}) {
    t.part.tree.seen[pair] = t.whole.tree.seen[pair] = 0;
    t.local.touch_pair(pair);
  }
  t.follow({});
  t.expect_equal();
  EXPECT_LT(t.part.cost(), t.part.now.sah_cost);
}

}  // namespace
}  // namespace regraft::test
