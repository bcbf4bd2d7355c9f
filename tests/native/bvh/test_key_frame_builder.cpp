#include "regraft/bvh/key_frame_builder.h"

#include <gtest/gtest.h>

#include "bvh/traps.h"
#include "bvh/trees.h"
#include "regraft/bvh/sah.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::KeyFrameBuilder;

Bvh build(const std::vector<Boxes>& poses, unsigned threads = 2,
          const KeyFrameBuilder::Config& config = {}) {
  std::vector<std::span<const Aabb>> frames;
  for (const Boxes& pose : poses) frames.emplace_back(pose.boxes);
  return KeyFrameBuilder::build(frames, poses[0].ids, config, pool(threads));
}

/// Boxes that walk along lines of their own; `time` 0 to 1.
Boxes pose(std::size_t count, double time) {
  Random random(9);
  std::vector<Aabb> all;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d from = random.in_box(1.0), to = random.in_box(1.0);
    all.push_back(cube(from + time * (to - from), 0.01));
  }
  return Boxes(all);
}

/// Mean cost of a tree refitted to many poses.
double mean_cost(Bvh tree, std::size_t count) {
  double sum = 0.0;
  for (int i = 0; i <= 10; ++i) {
    refit_to(tree, pose(count, 0.1 * i));
    sum += bvh::sah_cost(tree);
  }
  return sum / 11;
}

TEST(KeyFrameBuilder, NothingOneAndTwoPrimitives) {
  EXPECT_TRUE(build({Boxes()}).empty());
  for (const std::size_t count : {1, 2}) {
    const std::vector<Boxes> poses{random_boxes(count, 1), random_boxes(count, 2)};
    EXPECT_EQ(poses[0].flaw(build(poses)), "");
  }
}

TEST(KeyFrameBuilder, ForOnePoseItsTreeIsAsGoodAsTheBinnedBuilders) {
  const Boxes boxes = random_boxes(3000, 3);
  const Bvh tree = build({boxes});
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_NEAR(bvh::sah_cost(tree) / bvh::sah_cost(boxes.build()), 1.0, 0.02);
}

TEST(KeyFrameBuilder, OverAShotItBeatsTheTreeOfAnyOnePose) {
  const std::size_t count = 2000;
  const double shot = mean_cost(build({pose(count, 0), pose(count, 0.5), pose(count, 1)}), count);
  for (const double time : {0.0, 0.5, 1.0})
    EXPECT_LT(shot, 0.95 * mean_cost(pose(count, time).build(), count)) << time;
}

TEST(KeyFrameBuilder, TreesAreTheSameForAnyNumberOfThreads) {
  const std::vector<Boxes> poses{random_boxes(20000, 4), random_boxes(20000, 5)};
  const Bvh tree = build(poses, 1);
  EXPECT_EQ(poses[0].flaw(tree), "");
  EXPECT_TRUE(tree == build(poses, 2));
  EXPECT_TRUE(tree == build(poses, 5));
}

TEST(KeyFrameBuilder, NoInputMakesItDiveAndPrimitivesMayBeGoneInSomeFrames) {
  for (const Trap& trap : traps()) {
    SCOPED_TRACE(trap.name);
    std::vector<Boxes> poses{trap.boxes, random_boxes(trap.boxes.boxes.size(), 6), trap.boxes};
    for (std::size_t i = 0; i < poses[1].boxes.size(); i += 3) poses[1].boxes[i] = Aabb{};
    EXPECT_EQ(trap.boxes.flaw(build(poses)), "");
    poses[2].boxes.assign(poses[2].boxes.size(), Aabb{});
    EXPECT_EQ(trap.boxes.flaw(build(poses)), "");
  }
}

}  // namespace
}  // namespace regraft::test
