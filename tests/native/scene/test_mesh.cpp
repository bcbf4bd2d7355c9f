#include "regraft/scene/mesh.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "scene/shapes.h"

namespace regraft {
namespace {

using test::refusal;
using test::Square;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float inf = std::numeric_limits<float>::infinity();

Mesh single(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mesh mesh;
  mesh.vertices = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

bool degenerate(const Vec3& a, const Vec3& b, const Vec3& c) {
  return is_degenerate(single(a, b, c), 0);
}

TEST(Mesh, ATriangleOfOnePointOrOfALineIsDegenerate) {
  EXPECT_TRUE(degenerate({1, 2, 3}, {1, 2, 3}, {1, 2, 3}));
  EXPECT_TRUE(degenerate({1, 2, 3}, {1, 2, 3}, {4, 5, 6}));
  EXPECT_TRUE(degenerate({0, 0, 0}, {1, 1, 1}, {3, 3, 3}));
  EXPECT_TRUE(degenerate({0, -0.0f, 0}, {-0.0f, 0, 0}, {0, 0, 5}));
}

TEST(Mesh, ATriangleWithAVertexThatIsNotFiniteIsDegenerate) {
  EXPECT_TRUE(degenerate({nan, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_TRUE(degenerate({0, 0, 0}, {1, inf, 0}, {0, 1, 0}));
  EXPECT_TRUE(degenerate({0, 0, 0}, {1, 0, 0}, {0, 1, -inf}));
}

TEST(Mesh, ThinAndTinyAndHugeTrianglesAreNotDegenerate) {
  EXPECT_FALSE(degenerate({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(degenerate({0, 0, 0}, {1, 0, 0}, {0.5f, 1e-7f, 0}));
  EXPECT_FALSE(degenerate({0, 0, 0}, {1e-40f, 0, 0}, {0, 1e-45f, 0}));
  EXPECT_FALSE(degenerate({-1e30f, 0, 0}, {1e30f, 0, 0}, {0, 1e30f, 1e30f}));
  EXPECT_FALSE(degenerate({1e30f, 0, 0}, {1e30f, 1e-40f, 0}, {1e30f, 0, 1e-40f}));
}

TEST(Mesh, ASliverWhoseEdgesRoundInDoubleIsJudgedExactly) {
  // 1e20 + 1 is no double: the edges computed in double lose the small coordinates.
  EXPECT_FALSE(degenerate({1e20f, 1e20f, 0}, {1, 2, 0}, {2, 3, 0}));
  EXPECT_FALSE(degenerate({1e20f, 1e20f, 0}, {0, 0, 0}, {1e-20f, 2e-20f, 0}));
  EXPECT_TRUE(degenerate({1e20f, 1e20f, 1e20f}, {1e-20f, 1e-20f, 1e-20f}, {1, 1, 1}));
  const float next = std::nextafter(1e20f, inf);
  EXPECT_FALSE(degenerate({1e20f, next, 0}, {1, 1, 0}, {0, 0, 0}));
}

RC_GTEST_PROP(Mesh, DegenerateMeansACrossProductOfZeroInIntegerArithmetic, ()) {
  const auto coordinate = rc::gen::inRange(-5, 6);
  const auto point = rc::gen::container<std::array<int, 3>>(coordinate);
  const auto a = *point;
  const auto b = *point;
  const auto c = *point;
  const float scale = std::ldexp(1.0f, *rc::gen::inRange(-145, 120));
  const auto cross = [&](int i, int j) {
    return (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
  };
  const auto vec = [&](const std::array<int, 3>& p) { return Vec3(p[0], p[1], p[2]) * scale; };
  const bool zero = cross(0, 1) == 0 && cross(1, 2) == 0 && cross(2, 0) == 0;
  RC_CLASSIFY(zero);
  RC_ASSERT(degenerate(vec(a), vec(b), vec(c)) == zero);
}

RC_GTEST_PROP(Mesh, DegenerateIsExactForCoordinatesOfAllBits, ()) {
  // c lies on the line a b, but for `off` units in one coordinate: 2^24 fits float and the
  // determinant fits 64 bits.
  const auto part = rc::gen::inRange(-(1 << 22), 1 << 22);
  const std::array<int, 3> a{*part, *part, *part};
  const std::array<int, 3> step{*part, *part, *part};
  const int off = *rc::gen::inRange(0, 2);
  const auto at = [&](int k, int times) { return a[k] + times * step[k]; };
  const Vec3 c(at(0, 2) + off, at(1, 2), at(2, 2));
  const bool zero = off == 0 || (step[1] == 0 && step[2] == 0);
  RC_ASSERT(degenerate(Vec3(a[0], a[1], a[2]), Vec3(at(0, 1), at(1, 1), at(2, 1)), c) == zero);
}

TEST(Mesh, TriangleBoundsAreTightAndEmptyForATriangleThatCannotBeHit) {
  const Aabb box = triangle_bounds(single({3, 0, 1}, {1, 5, 0}, {2, 2, 9}), 0);
  EXPECT_EQ(box.lo, Vec3(1, 0, 0));
  EXPECT_EQ(box.hi, Vec3(3, 5, 9));
  EXPECT_TRUE(triangle_bounds(single({3, nan, 1}, {1, 5, 0}, {2, 2, 9}), 0).empty());
  EXPECT_TRUE(triangle_bounds(single({3, 0, 1}, {1, 5, 0}, {2, 2, inf}), 0).empty());
}

TEST(Mesh, CheckNamesTheTriangleAndTheVertexThatIsNotThere) {
  Square square;
  square.triangles[1].z = 4;
  EXPECT_EQ(refusal([&] { check_mesh_data(square.data(), "mesh 0 \"Sign\""); }),
            "mesh 0 \"Sign\": triangle 1 names vertex 4, but there are 4 vertices");
}

TEST(Mesh, CheckWantsOneSlotAndOneTripleOfNormalIdsATriangle) {
  Square square;
  square.slots = {0};
  EXPECT_EQ(refusal([&] { check_mesh_data(square.data(), "m"); }),
            "m: 1 slots for 2 triangles; one a triangle or none wanted");
  square.slots = {0, 1};
  square.normal_ids = {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}};
  EXPECT_EQ(refusal([&] { check_mesh_data(square.data(), "m"); }),
            "m: 3 normal_ids for 2 triangles; one a triangle or none wanted");
}

TEST(Mesh, CheckCountsTheNormalsThatAreNamed) {
  Square square;
  EXPECT_EQ(check_mesh_data(square.data(), ""), 0u);
  square.normal_ids = {{flat_corner, 2, 1}, {flat_corner, flat_corner, flat_corner}};
  EXPECT_EQ(check_mesh_data(square.data(), ""), 3u);
  square.normal_ids = square.triangles;
  EXPECT_EQ(check_mesh_data(square.data(), ""), 4u);
}

TEST(Mesh, CheckRefusesNormalIdsBeyondCornersAndVertices) {
  Square square;
  square.normal_ids = {{0, 5, 2}, {0, 2, 3}};
  EXPECT_EQ(check_mesh_data(square.data(), ""), 6u);
  square.normal_ids[1].x = 6;
  EXPECT_EQ(refusal([&] { check_mesh_data(square.data(), "m"); }),
            "m: normal id 6, below 6 wanted (vertices, or corners if more)");
}

TEST(Mesh, BytesCountTheArrays) {
  Mesh mesh = single({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const std::size_t before = mesh.bytes();
  EXPECT_GE(before, 3 * sizeof(Vec3) + sizeof(Triangle));
  mesh.slots.assign(1000, 0);
  EXPECT_GE(mesh.bytes(), before + 2000);
}

}  // namespace
}  // namespace regraft
