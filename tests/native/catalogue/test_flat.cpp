#include <gtest/gtest.h>

#include <cmath>

#include "trace/bed.h"

// Catalogue E: what has no thickness or lies in one plane, under every way to keep trees. How k-d
// trees cut it is in kdtree/test_flat_cells.cpp.

namespace regraft::test {
namespace {

TEST(FlatThings, AFloorWithBoxesBeginningAtEveryLineIsRight) {
  Bed bed;
  bed.add(floor_grid(8, 4.0f));
  for (int x = -4; x < 4; x += 2) bed.add(box(Vec3(x, -1, -1), Vec3(x + 2, 1, 0)));
  EXPECT_EQ(bed.problems(1, 128), "");
}

TEST(FlatThings, TwoFloorsInOnePlaceKeepTheirOrderOverFrames) {
  Bed bed(policies());
  const Geometry floor = floor_grid(5, 3.0f);
  const std::uint32_t below = bed.add(floor), above = bed.add(floor);
  const Ray ray{{0.35, 0.2, 5}, {0, 0, -1}};
  for (int frame = 0; frame < 5; ++frame) {
    const Geometry moved = floor.moved({0, 0, 0.25 * frame});
    // Updated in either order.
    bed.deform(frame % 2 == 0 ? below : above, moved);
    bed.deform(frame % 2 == 0 ? above : below, moved);
    ASSERT_EQ(bed.update(), "");
    ASSERT_EQ(bed.differences(std::span(&ray, 1)), "");
    EXPECT_EQ(bed.hits(std::span(&ray, 1))[0].instance, 0u);
  }
}

TEST(FlatThings, ASceneInOnePlaneHasNoVolumeAndIsRight) {
  for (int axis = 0; axis < 3; ++axis) {
    Bed bed;
    bed.add(soup(80, 2, 1.0, 0.4).mapped([&](Vec3d v) {
      v[axis] = 0.75;
      return v;
    }));
    EXPECT_EQ(bed.problems(2, 96), "") << axis;
  }
}

TEST(FlatThings, ASceneOnOneLineHasNothingToHit) {
  Bed bed;
  Geometry g;
  for (int i = 0; i < 20; ++i) {
    const auto x = float(i);
    g += triangle({x, 0, 0}, {x + 1, 0, 0}, {x + 3, 0, 0});
  }
  bed.add(g);
  EXPECT_EQ(bed.problems(3, 64), "");
}

TEST(FlatThings, BoxesThatAbutAndBoxesAStepApartAreRight) {
  Bed bed;
  const float next = std::nextafter(1.0f, 2.0f);
  bed.add(box({0, 0, 0}, {1, 1, 1}));
  bed.add(box({1, 0, 0}, {2, 1, 1}));
  bed.add(box({next, 1, 0}, {2, 2, 1}));
  bed.add(box({1, 1, 0}, {next, 2, 1}));
  std::vector<Ray> rays;
  for (const double x : {1.0, double(next), 0.5 * (1.0 + next)})
    for (const double y : {0.5, 1.0, 1.5})
      for (const double way : {-1.0, 1.0}) rays.push_back({{x, y, -3.0 * way}, {0, 0, way}});
  ASSERT_EQ(bed.problems(4, 128), "");
  EXPECT_EQ(bed.differences(rays), "");
  for (const Found& found : bed.hits(rays)) EXPECT_TRUE(found.hit());
}

}  // namespace
}  // namespace regraft::test
