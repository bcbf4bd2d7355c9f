#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "accel/tended.h"
#include "bvh/boxes.h"
#include "catalogue/size.h"
#include "regraft/bvh/morton_builder.h"
#include "trace/bed.h"

// Catalogue B: triangles that are hardly or not at all triangles.

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

/// A ball, a triangle with these corners, and rays at both.
struct Beside {
  Bed bed;
  std::uint32_t odd;

  Beside(const Vec3& a, const Vec3& b, const Vec3& c) {
    Geometry g = sphere(5, 7);
    odd = std::uint32_t(g.triangles.size());
    g += triangle(a, b, c);
    bed.add(g);
  }
  /// By the trees that are built whole: a k-d tree meets it only where rays go.
  bool counted() const {
    return std::all_of(setups().begin(), setups().end(), [&](const Setup& setup) {
      return setup.structure == accel::Structure::kdtree ||
             bed.warns(setup, "1 triangles of zero area left out");
    });
  }
  /// How often the odd triangle is hit, by rays at the ball and at itself.
  std::size_t hits() const {
    std::size_t sum = 0;
    for (const Found& found : bed.hits(nasty_rays(SceneOracle(bed.scene), 7, 256)))
      sum += found.prim == odd;
    return sum;
  }
};

TEST(Degenerate, ATriangleOfOnePointIsLeftOutAndCounted) {
  Beside point({2, 1, 0}, {2, 1, 0}, {2, 1, 0});
  EXPECT_EQ(point.bed.problems(1, 64), "");
  EXPECT_EQ(point.hits(), 0u);
  EXPECT_TRUE(point.counted());
}

TEST(Degenerate, ATriangleThatIsALineIsLeftOutAndCounted) {
  Beside line({0, 0, 0}, {1, 2, 0.5f}, {2, 4, 1});
  EXPECT_EQ(line.bed.problems(2, 64), "");
  EXPECT_EQ(line.hits(), 0u);
  EXPECT_TRUE(line.counted());
}

TEST(Degenerate, ANeedleTenMillionTimesAsLongAsWideIsHit) {
  Bed bed;
  bed.add(triangle({0, 0, 0}, {1, 0, 0}, {0.5f, 0x1p-23f, 0}));
  bed.add(needles(30, 3, 1.0, 1e-6));
  EXPECT_EQ(bed.problems(3, 192), "");
  const Ray inside{{0.5, 0x1p-25, 1}, {0, 0, -1}};
  EXPECT_EQ(bed.hits(std::span(&inside, 1))[0].t, 1.0f);
}

TEST(Degenerate, ASliverWithLessAreaThanAFloatResolvesIsHit) {
  for (const float width : {0x1p-40f, 0x1p-100f, 0x1p-140f}) {
    Bed bed;
    bed.add(triangle({-1, 0, 0}, {1, 0, 0}, {0, width, 0}));
    ASSERT_EQ(bed.problems(4, 96), "") << width;
    const Ray inside{{0, double(width) / 4, 1}, {0, 0, -1}};
    EXPECT_EQ(bed.hits(std::span(&inside, 1))[0].t, 1.0f) << width;
  }
}

TEST(Degenerate, AVertexThatIsNotFiniteTakesItsTriangleAlongAndNoOther) {
  for (const float bad : {nan, inf, -inf}) {
    Beside broken({2, 1, 0}, {bad, 1, 0}, {2, 3, 0});
    ASSERT_EQ(broken.bed.problems(5, 64), "") << bad;
    EXPECT_EQ(broken.hits(), 0u) << bad;
    for (const auto& setup : setups()) {
      const accel::UpdateStatistics& s = broken.bed.statistics(setup);
      EXPECT_TRUE(broken.bed.warns(setup, "1 triangles with non-finite vertices left out"))
          << setup;
      EXPECT_TRUE(std::isfinite(s.culling_efficiency)) << setup;
    }
  }
}

TEST(Degenerate, ThingsOfDenormalSizeAreHitAlikeByAll) {
  Bed bed;
  bed.add(sphere(6, 8).scaled(1e-40));
  ASSERT_EQ(bed.update(), "");
  std::vector<Ray> rays;
  Random random(6);
  for (int i = 0; i < 96; ++i) {
    const Vec3d from = 3e-40 * random.way();
    rays.push_back({from, glm::normalize(0.5e-40 * random.in_box(1.0) - from)});
    rays.push_back({0.5e-40 * random.in_box(1.0), random.way()});
  }
  EXPECT_EQ(bed.differences(rays), "");
  for (const Found& found : bed.hits(rays)) EXPECT_TRUE(found.hit());
}

TEST(Degenerate, ZerosOfBothSignsAreOneZero) {
  Geometry plus = floor_grid(4, 1.0f), minus = plus;
  for (Vec3& v : minus.vertices)
    for (int k = 0; k < 3; ++k) v[k] = v[k] == 0.0f ? -0.0f : v[k];
  Bed a, b;
  a.add(plus), b.add(minus);
  ASSERT_EQ(a.problems(7, 96) + b.problems(7, 96), "");
  std::vector<Ray> rays, mirrored;
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    const double x = double(random.below(5)) / 2 - 1, y = random.uniform(-1.0, 1.0);
    rays.push_back({{x, y, 1}, {0.0, i % 2 == 0 ? 0.0 : y, -1}});
    mirrored.push_back({{x, y, 1}, {-0.0, i % 2 == 0 ? -0.0 : y, -1}});
  }
  const std::vector<Found> one = a.hits(rays), other = b.hits(mirrored);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(one[i].prim, other[i].prim) << rays[i];
    EXPECT_EQ(one[i].t, other[i].t) << rays[i];
  }
}

TEST(Degenerate, ManyDuplicatesOfOneTriangleMakeAShallowTreeOfLinearSize) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    std::uint64_t bytes[2];
    for (const unsigned half : {1u, 0u}) {
      Tended t;
      Geometry g = triangle({0, 0, 0}, {1, 0, 0.5f}, {0, 1, 0.25f});
      g.triangles.resize(very_many >> half, g.triangles[0]);
      add(t.scene, g);
      bytes[half] = t.update(Policy::automatic, layout).memory_bytes;
      const Ray ray{{0.25, 0.25, 1}, {0, 0, -1}};
      const std::vector<Found> wanted = hits_anew(t.scene, std::span(&ray, 1));
      EXPECT_EQ(wanted[0].prim, 0u);
      EXPECT_EQ(difference(t.accelerator.view(), t.width, std::span(&ray, 1), wanted), "");
    }
    EXPECT_LT(double(bytes[0]), 2.2 * double(bytes[1]));
  }
  const Boxes equal(std::vector<Aabb>(very_many, cube(Vec3d(1, 2, 3), 0.5)));
  EXPECT_LE(equal.build().depth, 20u);
}

TEST(Degenerate, EqualCentroidsOfManySizesMakeNoDeepTree) {
  std::vector<Aabb> nested;
  for (std::uint32_t i = 0; i < very_many; ++i) nested.push_back(cube(Vec3d(1, 2, 3), 1e-4 * i));
  const Boxes boxes(std::move(nested));
  const bvh::Bvh binned = boxes.build();
  EXPECT_LE(binned.depth, bvh::max_depth);
  EXPECT_EQ(boxes.flaw(binned), "");
  const bvh::Bvh along_a_curve = bvh::MortonBuilder::build(boxes.boxes, boxes.ids, {}, pool(2));
  EXPECT_LE(along_a_curve.depth, bvh::max_depth);
  EXPECT_EQ(boxes.flaw(along_a_curve), "");
}

TEST(Degenerate, TheOtherWindingIsHitInTheSamePlaces) {
  Geometry flipped = soup(60, 9, 1.0, 0.4);
  Bed as_is, turned;
  as_is.add(flipped);
  for (Triangle& t : flipped.triangles) std::swap(t[1], t[2]);
  turned.add(flipped);
  ASSERT_EQ(turned.problems(9, 64), "");
  const std::vector<Ray> rays = nasty_rays(SceneOracle(turned.scene), 10, 256);
  ASSERT_EQ(as_is.complaints(rays) + turned.complaints(rays), "");
  const SceneOracle oracle(as_is.scene);
  const std::vector<Found> one = as_is.hits(rays), other = turned.hits(rays);
  std::size_t clear = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (oracle.surely_nearest(rays[i], 1e-4) == nullptr) continue;
    ++clear;
    EXPECT_EQ(one[i].prim, other[i].prim) << rays[i];
  }
  EXPECT_GT(clear, 50u);
}

}  // namespace
}  // namespace regraft::test
