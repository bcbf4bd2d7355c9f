#include "regraft/kdtree/seeded_builder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kdtree/stand.h"
#include "regraft/kdtree/clip.h"
#include "regraft/kdtree/refinement.h"

namespace regraft::test {
namespace {

using kdtree::Refine;
using kdtree::Refinement;

/// A row of 4^6 unit cubes on the x axis in a tree of fan-out 4. The boxes of its first `veiled`
/// levels tell nothing: each is the whole row's.
class Row final : public HierarchyView {
 public:
  static constexpr std::uint32_t levels = 6;

  explicit Row(std::uint32_t veiled = 0) : veiled_(veiled) {}

  void top(std::vector<HierarchyEntry>& out) const override { out.push_back(entry(0, 0)); }
  void open(const HierarchyEntry& e, std::vector<HierarchyEntry>& out) const override {
    for (std::uint32_t c = 0; c < 4; ++c) out.push_back(entry(e.object + 1, 4 * e.node + c));
  }
  Aabb clip(const HierarchyEntry& primitive, const Aabb& voxel) const override {
    Aabb box = primitive.box;
    return kdtree::cut(box, voxel) ? box : Aabb{};
  }
  std::uint32_t fan_out() const override { return 4; }

 private:
  HierarchyEntry entry(std::uint32_t level, std::uint32_t index) const {
    const auto below = std::uint32_t(1) << (2 * (levels - level));
    const float first = level < veiled_ ? 0.0f : float(index * below);
    const float last = level < veiled_ ? 4096.0f : first + float(below);
    return {{{first, 0, 0}, {last, 1, 1}}, double(below), level, level == levels ? 0u : 1u, index};
  }

  std::uint32_t veiled_;
};

kdtree::Pending everything(const HierarchyView& view) {
  return kdtree::SeededBuilder(view, {}).root();
}

TEST(SeededBuilder, RefinementStopsWithinAFanOutOfItsGoal) {
  const Row row;
  for (const auto order : {Refine::fifo, Refine::area})
    for (const std::size_t goal : {1u, 10u, 50u, 500u}) {
      Refinement list(row, order, everything(row));
      list.open_until(goal);
      EXPECT_GE(list.size(), goal);
      EXPECT_LE(list.size(), std::max<std::size_t>(1, goal + 4 - 2));
      EXPECT_EQ(list.weight(), 4096.0);
    }
}

TEST(SeededBuilder, AListThatIsLongAlreadyIsNotRefined) {
  const Row row;
  Refinement list(row, Refine::fifo, everything(row));
  list.open_until(100);
  kdtree::Pending node = everything(row);
  node.list.assign(list.compacted().begin(), list.compacted().end());
  const std::size_t size = node.list.size();
  Refinement again(row, Refine::fifo, node);
  again.open_until(50);
  EXPECT_EQ(again.size(), size);
}

TEST(SeededBuilder, WhatLiesOutsideTheVoxelIsDroppedAndBoxesAreCutToIt) {
  const Row row;
  const kdtree::SeededBuilder builder(row, {});
  const Aabb voxel{{100.5f, 0, 0}, {103.0f, 1, 1}};
  Refinement list(row, Refine::fifo, builder.seed(voxel, 0, 1e9));
  list.open_until(std::size_t(-1));
  const std::span<const HierarchyEntry> entries = list.compacted();
  ASSERT_EQ(entries.size(), 3u);
  for (const HierarchyEntry& e : entries) {
    EXPECT_TRUE(e.primitive());
    EXPECT_TRUE(voxel.contains(e.box));
  }
}

TEST(SeededBuilder, OnlyTheHeaviestStraddlersAreOpened) {
  const Row row;
  Refinement list(row, Refine::fifo, everything(row));
  list.open_until(4);
  kdtree::Split split;
  split.axis = 0;
  split.position = 1500.0f;
  EXPECT_TRUE(list.open_straddlers(split, 1));
  EXPECT_EQ(list.size(), 7u);
  split.position = 1024.0f;
  EXPECT_FALSE(list.open_straddlers(split, 16));
}

TEST(SeededBuilder, ANodeIsSplitAndItsWeightsAreShared) {
  const Row row;
  const kdtree::SeededBuilder builder(row, {});
  const kdtree::Built built = builder.build(builder.root());
  ASSERT_EQ(built.axis, 0);
  EXPECT_EQ(built.children[0].weight + built.children[1].weight, 4096.0);
  EXPECT_EQ(built.children[0].voxel.hi.x, built.position);
  EXPECT_NEAR(built.children[0].budget + built.children[1].budget, builder.root().budget, 1e-6);
}

TEST(SeededBuilder, WhereNoSplitPaysItDigsFiveTimesAsDeepAndNoDeeper) {
  kdtree::Config config;
  config.refine_to = 10;
  const std::size_t fan_out = 4, limit = 5 * (config.refine_to + fan_out);
  {
    // 4^3 entries have to be seen before a plane parts them: within the limit.
    const Row row(3);
    const kdtree::SeededBuilder builder(row, config);
    const kdtree::Built built = builder.build(builder.root());
    ASSERT_EQ(built.axis, 0);
    for (const kdtree::Pending& child : built.children)
      EXPECT_LE(child.list.size(), limit + fan_out - 2);
  }
  {
    // 4^5 would have to be.
    const Row row(5);
    const kdtree::SeededBuilder builder(row, config);
    const kdtree::Built built = builder.build(builder.root());
    EXPECT_EQ(built.axis, -1);
    EXPECT_EQ(built.prims.size(), 4096u);
  }
}

TEST(ClipTriangle, TheBoxOfThePartInsideIsTightAndRoundedOutward) {
  const Vec3d corners[3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Aabb part = kdtree::clip_triangle(corners, Vec3d(0.0), {{1, 1, -1}, {9, 9, 1}});
  const float above = std::nextafter(3.0f, 4.0f);
  EXPECT_TRUE(part.contains({{1, 1, 0}, {3, 3, 0}}));
  EXPECT_TRUE((Aabb{{1, 1, 0}, {above, above, 0}}).contains(part));
  EXPECT_TRUE(kdtree::clip_triangle(corners, Vec3d(0.0), {{2.5f, 2.5f, -1}, {9, 9, 1}}).empty());
}

TEST(ClipTriangle, TheMarginIsAddedOnAllSides) {
  const Vec3d corners[3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Aabb near = kdtree::clip_triangle(corners, Vec3d(0.5), {{-9, -9, 0.25f}, {9, 9, 9}});
  EXPECT_EQ(near, (Aabb{{-0.5f, -0.5f, 0.25f}, {4.5f, 4.5f, 0.5f}}));
  EXPECT_TRUE(kdtree::clip_triangle(corners, Vec3d(0.5), {{-9, -9, 0.75f}, {9, 9, 9}}).empty());
}

TEST(ClipTriangle, PointsOfTheTriangleInsideAreInTheBox) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const Vec3d corners[3] = {random.in_box(1), random.in_box(1), random.in_box(1)};
    Aabb voxel;
    voxel.extend(Vec3(random.in_box(0.8)));
    voxel.extend(Vec3(random.in_box(0.8)));
    const Aabb part = kdtree::clip_triangle(corners, Vec3d(0.0), voxel);
    EXPECT_TRUE(voxel.contains(part));
    for (int j = 0; j < 50; ++j) {
      double u = random.uniform(0, 1), v = random.uniform(0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 p(corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]));
      const Aabb point{p, p};
      if (voxel.contains(point)) {
        EXPECT_TRUE(part.contains(point));
      }
    }
  }
}

TEST(ClipTriangle, OnePlaneKeepsOfATriangleWhatClippingToItsSidesKeeps) {
  const Vec3d corners[3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Aabb whole{{0, 0, 0}, {4, 4, 0}};
  Aabb sides[2];
  kdtree::clip_triangle_sides(corners, Vec3d(0.0), whole, 0, 3.0f, sides);
  EXPECT_TRUE(sides[0].contains({{0, 0, 0}, {3, 4, 0}}));
  EXPECT_EQ(sides[1].hi.x, 4.0f);
  EXPECT_NEAR(sides[1].hi.y, 1.0f, 1e-6f);
}

TEST(ClipTriangle, PlaneAfterPlaneItsBoxHoldsWhatClippingToTheCellHolds) {
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const Vec3d corners[3] = {random.in_box(1), random.in_box(1), random.in_box(1)};
    const Vec3d margin(i % 2 == 0 ? 0.0 : 0.01);
    Aabb cell{Vec3(-2), Vec3(2)}, box = kdtree::clip_triangle(corners, margin, cell);
    for (int cuts = 0; cuts < 6 && !box.empty(); ++cuts) {
      const int axis = cuts % 3, side = int(random.below(2));
      const auto plane = float(random.uniform(box.lo[axis], box.hi[axis]));
      Aabb sides[2];
      kdtree::clip_triangle_sides(corners, margin, box, axis, plane, sides);
      (side == 0 ? cell.hi : cell.lo)[axis] = plane;
      EXPECT_TRUE(sides[side].empty() || box.contains(sides[side]));
      box = sides[side];
      const Aabb exact = kdtree::clip_triangle(corners, margin, cell);
      EXPECT_TRUE(exact.empty() || box.contains(exact)) << i << ' ' << cuts;
    }
  }
}

}  // namespace
}  // namespace regraft::test
