#include "regraft/bvh/edit.h"

#include <gtest/gtest.h>

#include "bvh/trees.h"
#include "bvh/wide_check.h"
#include "regraft/bvh/sah.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::WideBvh;

/// A tree and its wide layout, edited together.
struct Edited {
  Boxes boxes;
  Bvh tree;
  WideBvh wide;
  bvh::BinnedSahBuilder::Config builder;

  explicit Edited(std::size_t count, std::uint64_t seed = 1)
      : boxes(random_boxes(count, seed)),
        tree(boxes.build()),
        wide(WideBvh::derive(tree, 8, pool(2))) {}

  bool edit(const std::vector<std::uint32_t>& new_ids,
            const std::vector<std::vector<std::uint32_t>>& added) {
    bvh::Reshaping changes;
    const auto bounds = [&](std::uint32_t i) { return bvh::Box4(boxes.boxes[i]); };
    const bool done = bvh::edit(tree, {new_ids, added}, bounds, builder, pool(2), changes);
    if (done) wide.update(tree, changes, pool(2));
    return done;
  }
  std::string flaw() const {
    const std::string of_tree = boxes.flaw(tree);
    return of_tree.empty() ? test::flaw(wide, tree) : of_tree;
  }
};

/// Drops the primitives for which `gone` says so, numbers the rest anew and adds chunks.
void change(Edited& edited, Random& random, double share_gone, std::size_t chunks) {
  std::vector<Aabb> kept;
  std::vector<std::uint32_t> new_ids;
  for (const Aabb& box : edited.boxes.boxes) {
    const bool gone = random.uniform(0.0, 1.0) < share_gone;
    new_ids.push_back(gone ? invalid_id : std::uint32_t(kept.size()));
    if (!gone) kept.push_back(box);
  }
  std::vector<std::vector<std::uint32_t>> added(chunks);
  for (std::vector<std::uint32_t>& chunk : added) {
    const Vec3d center = random.in_box(1.5);
    for (std::size_t i = random.below(30); i > 0; --i) {
      chunk.push_back(std::uint32_t(kept.size()));
      kept.push_back(cube(center + random.in_box(0.1), 0.02));
    }
  }
  edited.boxes = Boxes(kept);
  ASSERT_TRUE(edited.edit(new_ids, added));
}

TEST(Edit, PrimitivesComeAndGoThroughManyFrames) {
  for (const std::size_t count : {0, 1, 2, 50, 3000}) {
    Edited edited(count);
    Random random(count);
    for (int frame = 0; frame < 40; ++frame) {
      change(edited, random, 0.02 * (frame % 4), frame % 3 == 0 ? 0 : 1 + count / 300);
      ASSERT_EQ(edited.flaw(), "") << count << ", frame " << frame;
    }
    if (count < 3000) continue;
    EXPECT_LT(bvh::sah_cost(edited.tree), 1.5 * bvh::sah_cost(edited.boxes.build()));
  }
}

TEST(Edit, AllMayGoAndComeBack) {
  Edited edited(200);
  const Boxes all = edited.boxes;
  edited.boxes = Boxes();
  ASSERT_TRUE(edited.edit(std::vector<std::uint32_t>(200, invalid_id), {}));
  EXPECT_TRUE(edited.tree.empty());
  EXPECT_EQ(edited.flaw(), "");
  edited.boxes = all;
  ASSERT_TRUE(edited.edit({}, {all.ids}));
  EXPECT_EQ(edited.flaw(), "");
}

TEST(Edit, WithoutAChangeNothingChanges) {
  Edited edited(500);
  const Bvh before = edited.tree;
  ASSERT_TRUE(edited.edit({}, {}));
  EXPECT_TRUE(edited.tree == before);
}

TEST(Edit, ANewPrimitiveHangsWhereAreasGrowLeast) {
  // Two heaps far apart, and one more box beside the second.
  std::vector<Aabb> all;
  for (int i = 0; i < 20; ++i) all.push_back(cube({i < 10 ? 0.0 : 100.0, i % 10 * 1.0, 0}, 0.4));
  Edited edited(0);
  edited.boxes = Boxes(all);
  edited.tree = edited.boxes.build();
  edited.wide = WideBvh::derive(edited.tree, 8, pool(1));
  const double area = half_area(edited.tree.nodes[edited.tree.nodes[0].first].bounds());
  all.push_back(cube({100.0, 5.5, 0}, 0.4));
  edited.boxes = Boxes(all);
  ASSERT_TRUE(edited.edit({}, {{20}}));
  EXPECT_EQ(edited.flaw(), "");
  const bvh::Node& root = edited.tree.nodes[0];
  EXPECT_NEAR(half_area(edited.tree.nodes[root.first].bounds()), area, 1e-3);
  EXPECT_NEAR(half_area(edited.tree.nodes[root.first + 1].bounds()), area, 1e-3);
}

TEST(Edit, RoomLeftByRemovalIsGivenBackInTheEnd) {
  Edited edited(1000);
  Random random(5);
  for (int frame = 0; frame < 12; ++frame) change(edited, random, 0.2, 0);
  EXPECT_EQ(edited.flaw(), "");
  EXPECT_LE(edited.tree.prim_ids.size(), 2 * edited.boxes.ids.size());
}

TEST(Edit, RefusesToGrowTooDeep) {
  std::vector<Aabb> all;
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i <= bvh::max_depth; ++i) {
    all.push_back(cube({std::exp2(double(i)), 0, 0}, 0.1));
    order.push_back(bvh::max_depth - i);
  }
  Edited edited(0);
  edited.boxes = Boxes(all);
  edited.tree = chain_tree(edited.boxes, order);
  all.push_back(cube({1.5, 0, 0}, 0.1));
  edited.boxes = Boxes(all);
  EXPECT_FALSE(edited.edit({}, {{bvh::max_depth + 1}}));
}

TEST(Edit, ExtremeBoxesAreInsertedLikeAnyOther) {
  for (const double scale : {0.0, 1e-42, 1e30}) {
    Edited edited(0);
    std::vector<Aabb> all;
    for (int i = 0; i < 60; ++i) {
      all.push_back(cube({(i * 37 % 50 - 25) * scale, i * scale, 0}, 0.1 * scale));
      edited.boxes = Boxes(all);
      ASSERT_TRUE(edited.edit({}, {{std::uint32_t(i)}}));
      ASSERT_EQ(edited.flaw(), "") << scale << ", " << i;
    }
  }
}

}  // namespace
}  // namespace regraft::test
