#include "regraft/kdtree/solid_angle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace regraft::test {
namespace {

using kdtree::box_solid_angle;
using kdtree::triangle_solid_angle;

constexpr double pi = std::numbers::pi;

TEST(SolidAngle, OfAnOctantIsAnEighthOfTheSphere) {
  EXPECT_NEAR(triangle_solid_angle({1, 0, 0}, {0, 2, 0}, {0, 0, 3}), pi / 2, 1e-14);
  EXPECT_NEAR(triangle_solid_angle({1, 0, 0}, {0, 0, 3}, {0, 2, 0}), pi / 2, 1e-14);
}

TEST(SolidAngle, OfABoxIsTheSphereFromInsideAndASixthOfItPerFaceFromItsCentre) {
  EXPECT_EQ(box_solid_angle(Vec3d(-1), Vec3d(1), Vec3d(0.3)), 4 * pi);
  const Vec3d face_lo(-1, -1, 1);
  EXPECT_NEAR(box_solid_angle(face_lo, Vec3d(1, 1, 1), Vec3d(0)), 4 * pi / 6, 1e-14);
}

TEST(SolidAngle, OfABoxSeenFromJustAboveAFaceIsAHalfSphere) {
  EXPECT_NEAR(box_solid_angle(Vec3d(0), Vec3d(1), Vec3d(0.3, 0.6, -1e-12)), 2 * pi, 1e-10);
  // Over the diagonal, the edge of both triangles, half of the digits is all there is.
  EXPECT_NEAR(box_solid_angle(Vec3d(0), Vec3d(1), Vec3d(0.5, 0.5, -1e-9)), 2 * pi, 1e-6);
}

TEST(SolidAngle, FarAwayIsAreaOverSquaredDistance) {
  for (const double distance : {1e3, 1e6, 1e9}) {
    const double seen = box_solid_angle(Vec3d(-0.5), Vec3d(0.5), Vec3d(0, 0, distance));
    EXPECT_NEAR(seen * distance * distance, 1.0, 3.0 / distance);
  }
}

TEST(SolidAngle, OfAFarFaceSeenEdgeOnKeepsItsDigits) {
  // A unit square 1e6 away and `tilt` below the eye: its sine times area over distance squared.
  const double away = 1e6;
  for (const double tilt : {1.0, 1e-3, 1e-6}) {
    const Vec3d a(away, 0, -tilt);
    const Vec3d b(away + 1, 0, -tilt);
    const Vec3d c(away, 1, -tilt);
    const double expected = 0.5 * tilt / (away * away * away);
    EXPECT_NEAR(triangle_solid_angle(a, b, c) / expected, 1.0, 3e-6) << tilt;
  }
}

}  // namespace
}  // namespace regraft::test
