#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "trace/bed.h"

// Catalogue D: how large things are, and where.

namespace regraft::test {
namespace {

Mat4d at(const Vec3d& p) {
  return glm::translate(Mat4d(1.0), p);
}

Mat4d scale(double s) {
  return glm::scale(Mat4d(1.0), Vec3d(s));
}

/// A ball and a soup, their vertices `size` times as large, placed by `m`.
std::string problems_of(double size, const Mat4d& m, std::uint64_t seed) {
  Bed bed;
  bed.add(sphere(6, 8).scaled(size), m);
  bed.add(soup(40, seed, 1.5, 0.4).scaled(size), m);
  std::string error = bed.problems(seed, 72);
  for (const auto& setup : setups())
    if (error.empty() && !std::isfinite(bed.statistics(setup).culling_efficiency))
      error = text(setup, ": a cost that is not finite");
  return error;
}

TEST(Scale, OfAMillionthIsRight) {
  EXPECT_EQ(problems_of(1e-6, Mat4d(1.0), 1), "");
  EXPECT_EQ(problems_of(1.0, scale(1e-6), 1), "");
}

TEST(Scale, OfATrillionIsRight) {
  EXPECT_EQ(problems_of(1e12, Mat4d(1.0), 2), "");
  EXPECT_EQ(problems_of(1.0, scale(1e12), 2), "");
}

TEST(Scale, OfExtentsNearTheLargestFloatsIsRightAndItsCostFinite) {
  EXPECT_EQ(problems_of(1e30, Mat4d(1.0), 3), "");
  EXPECT_EQ(problems_of(1.0, scale(1e30), 3), "");
}

TEST(Scale, OfExtentsNearTheSmallestFloatsIsRightAndItsCostFinite) {
  EXPECT_EQ(problems_of(1e-30, Mat4d(1.0), 4), "");
  EXPECT_EQ(problems_of(1.0, scale(1e-30), 4), "");
}

TEST(Place, AMillionAndABillionUnitsAwayIsRight) {
  for (const double far : {1e6, 1e9})
    EXPECT_EQ(problems_of(1.0, at({far, -far, 0.5 * far}), 5), "") << far;
}

TEST(Place, ATrillionSizesAwayIsTheSameInEveryTree) {
  // Walls across an axis fill their boxes: a ray that rounding moves by a little meets the wall
  // although it passes the box.
  Geometry walls;
  for (const Vec3d& p : {Vec3d(-1, -1, -1), Vec3d(1, 0.5, 0), Vec3d(0, 1, 1)})
    walls += floor_grid(3, 0.1f).moved(p);
  Random random(10);
  const Vec3d far(0x1p40, -0x1p40, 0x1p40);
  Bed bed;
  std::vector<Ray> rays;
  for (int i = 0; i < 4; ++i) {
    const Mat4d m = at(far + random.in_box(1.0)) * scale(random.uniform(0.2, 0.4));
    bed.add(walls, m);
    for (const Vec3& corner : walls.vertices) {
      const Vec3d from = far + 2.0 * random.in_box(1.0);
      rays.push_back({from, Vec3d(m * glm::dvec4(corner, 1.0)) - from});
    }
  }
  ASSERT_EQ(bed.update(), "");
  EXPECT_EQ(bed.differences(rays), "");
}

TEST(Scale, ATeapotInAStadiumABillionTimesItsSizeIsHitWhereItIs) {
  Bed bed;
  const std::uint32_t teapot = bed.add(sphere(8, 12));
  bed.add(box({-5e8, -5e8, -1}, {5e8, 5e8, 5e8}));
  ASSERT_EQ(bed.problems(6, 96), "");
  Scene alone;
  add(alone, sphere(8, 12));
  const SceneOracle oracle(alone);
  Random random(6);
  std::vector<Ray> rays;
  for (int i = 0; i < 96; ++i) {
    const Vec3d from = Vec3d(0, 0, 2) + 0.9 * random.in_box(1.0);
    rays.push_back({from, 0.3 * random.in_box(1.0) - from});
  }
  EXPECT_EQ(bed.differences(rays), "");
  const std::vector<Found> found = bed.hits(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(found[i].instance, teapot);
    EXPECT_EQ(oracle.complaint(rays[i], found[i]), "");
  }
}

TEST(Scale, AWireAHundredMillionTimesAsLongAsThickIsRight) {
  for (int axis = 0; axis < 3; ++axis) {
    Bed bed;
    Vec3 lo(-0.5f), hi(0.5f);
    lo[axis] = -5e7f, hi[axis] = 5e7f;
    bed.add(box(lo, hi));
    bed.add(sphere(5, 7), at({0, 0, 3}));
    ASSERT_EQ(bed.problems(7, 96), "") << axis;
    // Across it from close by: no coordinate that counts is a large one.
    std::vector<Ray> rays;
    Random random(7);
    for (int i = 0; i < 48; ++i) {
      Vec3d from = 0.5 * random.in_box(1.0);
      const Vec3d to = 0.8 * from;
      from[(axis + 1) % 3] = 2.0;
      rays.push_back({from, to - from});
    }
    EXPECT_EQ(bed.differences(rays), "") << axis;
    for (const Found& found : bed.hits(rays)) EXPECT_TRUE(found.hit()) << axis;
  }
}

TEST(Place, BetweenAMillionthAndATrillionBothEndsAreHit) {
  Bed bed;
  const std::uint32_t near = bed.add(sphere(6, 8), at({0, 0, -2e-6}) * scale(1e-6));
  const std::uint32_t far = bed.add(sphere(6, 8), at({0, 0, -9e11}) * scale(1e11));
  ASSERT_EQ(bed.update(), "");
  std::vector<Ray> rays;
  Random random(8);
  for (int i = 0; i < 64; ++i) {
    const Vec3d aside(random.uniform(-1e-7, 1e-7), random.uniform(-1e-7, 1e-7), 0.0);
    rays.push_back({aside, {0, 0, -1}, 1e-7f, 1e12f});
    rays.push_back({aside, {0, 0, -1}, 1e-5f, 1e12f});
  }
  EXPECT_EQ(bed.differences(rays), "");
  const std::vector<Found> found = bed.hits(rays);
  for (std::size_t i = 0; i < rays.size(); ++i)
    EXPECT_EQ(found[i].instance, i % 2 == 0 ? near : far);
}

TEST(Place, ABallAMillionUnitsAwayIsHitInANarrowView) {
  Bed bed;
  bed.add(sphere(12, 16));
  ASSERT_EQ(bed.update(), "");
  std::vector<Ray> rays;
  Random random(9);
  for (int i = 0; i < 96; ++i) {
    const Vec3d from = 1e6 * random.way();
    const Vec3d to = 0.9 / std::sqrt(3.0) * random.in_box(1.0);
    rays.push_back({from, to - from});
    rays.push_back({from, (to - from) * 1e-6});
  }
  EXPECT_EQ(bed.differences(rays), "");
  EXPECT_EQ(bed.complaints(rays), "");
  for (const Found& found : bed.hits(rays)) EXPECT_TRUE(found.hit());
}

}  // namespace
}  // namespace regraft::test
