#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "trace/bed.h"

// Catalogue C: rays against boxes, in the planes of both.

namespace regraft::test {
namespace {

/// 3 × 3 × 3 closed cells that share their walls: whatever starts inside hits something, and
/// boxes begin and end in all planes of whole numbers.
struct Cells {
  Bed bed;

  Cells() {
    Geometry cells;
    for (int i = 0; i < 27; ++i) {
      const Vec3 lo(float(i % 3), float(i / 3 % 3), float(i / 9));
      cells += box(lo, lo + Vec3(1.0f));
    }
    bed.add(cells);
  }
  /// The first problem with these rays, of which none may miss, or "".
  std::string lost(std::span<const Ray> rays) {
    std::string error = bed.update();
    if (error.empty()) error = bed.differences(rays);
    const std::vector<Found> found = bed.hits(rays);
    for (std::size_t i = 0; i < rays.size() && error.empty(); ++i)
      if (!found[i].hit()) error = text("nothing was hit by ", rays[i]);
    return error;
  }
};

/// Whole numbers are planes of boxes.
double plane(Random& random) {
  return double(random.below(4));
}

TEST(RaysInPlanes, WithOneComponentZeroOfEitherSignAreNotLost) {
  Random random(1);
  std::vector<Ray> rays;
  for (int i = 0; i < 120; ++i) {
    const int axis = i % 3;
    Ray ray{{random.uniform(0, 3), random.uniform(0, 3), random.uniform(0, 3)}, random.way()};
    ray.origin[axis] = plane(random);
    ray.direction[axis] = i % 2 == 0 ? 0.0 : -0.0;
    rays.push_back(ray);
  }
  EXPECT_EQ(Cells().lost(rays), "");
}

TEST(RaysInPlanes, WithTwoComponentsZeroAreNotLost) {
  Random random(2);
  std::vector<Ray> rays;
  for (int i = 0; i < 120; ++i) {
    const int axis = i % 3;
    Ray ray{{plane(random), plane(random), plane(random)}, Vec3d(i % 2 == 0 ? 0.0 : -0.0)};
    if (i % 4 < 2) ray.origin[(axis + 1) % 3] = random.uniform(0, 3);
    ray.origin[axis] = i % 8 < 4 ? -1.0 : 4.0;
    ray.direction[axis] = i % 8 < 4 ? 1.0 : -1.0;
    rays.push_back(ray);
  }
  EXPECT_EQ(Cells().lost(rays), "");
}

TEST(RaysInPlanes, FromTheCornerOfABoxAreNotLost) {
  Random random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 120; ++i) {
    const Vec3d corner(double(1 + random.below(2)), double(1 + random.below(2)),
                       double(1 + random.below(2)));
    rays.push_back({corner, random.way()});
  }
  EXPECT_EQ(Cells().lost(rays), "");
}

TEST(RaysInPlanes, InAFlatBoxReachWhatIsBehindAndDoNotHitItsTriangles) {
  Bed bed;
  const std::uint32_t room = bed.add(box({-5, -5, -5}, {5, 5, 5}));
  bed.add(floor_grid(6, 3.0f));
  ASSERT_EQ(bed.update(), "");
  Random random(4);
  std::vector<Ray> rays;
  for (int i = 0; i < 120; ++i) {
    Ray ray{{random.uniform(-4, 4), random.uniform(-4, 4), 0.0}, random.way()};
    if (i % 3 == 0) ray.origin.x = double(random.below(7)) - 3.0;
    if (i % 4 == 0) ray.direction.x = 0.0;
    ray.direction.z = i % 2 == 0 ? 0.0 : -0.0;
    rays.push_back(ray);
  }
  EXPECT_EQ(bed.differences(rays), "");
  EXPECT_EQ(bed.complaints(rays), "");
  for (const Found& found : bed.hits(rays)) EXPECT_EQ(found.instance, room);
}

/// What rays from inside a ball hit, their directions changed by `change`, beside what they hit
/// as they are.
template <typename Change, typename Compare>
void compare(std::uint64_t seed, const Change& change, const Compare& compare_hits) {
  Bed bed;
  bed.add(sphere(8, 12));
  ASSERT_EQ(bed.update(), "");
  Random random(seed);
  std::vector<Ray> plain, changed;
  for (int i = 0; i < 96; ++i) {
    plain.push_back({0.5 * random.in_box(1.0), random.way()});
    changed.push_back(plain.back());
    change(i, plain.back(), changed.back());
  }
  ASSERT_EQ(bed.differences(changed), "");
  const std::vector<Found> wanted = bed.hits(plain), found = bed.hits(changed);
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_TRUE(found[i].hit()) << changed[i];
    compare_hits(wanted[i], found[i]);
  }
}

TEST(RayDirections, ADenormalComponentIsAsGoodAsZero) {
  const auto flatten = [](int i, Ray& plain, Ray& changed) {
    plain.direction[i % 3] = 0.0;
    changed.direction[i % 3] = i % 2 == 0 ? 1e-40 : -1e-40;
  };
  compare(5, flatten, [](const Found& wanted, const Found& found) {
    EXPECT_EQ(found.prim, wanted.prim);
    EXPECT_EQ(found.t, wanted.t);
  });
}

TEST(RayDirections, HugeAndTinyOnesScaleTAndHitTheSame) {
  for (const double length : {1e30, 1e-30}) {
    const auto scale = [&](int, Ray&, Ray& changed) { changed.direction *= length; };
    compare(6, scale, [&](const Found& wanted, const Found& found) {
      EXPECT_EQ(found.prim, wanted.prim);
      EXPECT_NEAR(double(found.t) * length, double(wanted.t), 1e-6 * wanted.t);
    });
  }
}

TEST(RayIntervals, ThatEndAtAHitHoldItAndThoseAStepShorterDoNot) {
  Bed bed;
  bed.add(sphere(8, 12));
  bed.add(soup(60, 7, 1.0, 0.4));
  EXPECT_EQ(bed.problems(7, 128), "");
}

TEST(RayIntervals, BeyondTheLargestFloatThereIsNothing) {
  Bed bed;
  bed.add(box({-1, -1, -1}, {1, 1, 1}));
  bed.add(floor_grid(4, 1e30f).moved({0, 0, -1e30}));
  ASSERT_EQ(bed.update(), "");
  // The same places with ever shorter steps: t grows until no float holds it.
  std::size_t hits = 0;
  std::vector<Ray> rays;
  for (int exponent = -20; exponent <= 0; ++exponent)
    for (const Vec3d& from : {Vec3d(0.1, 0.2, 5), Vec3d(1e20, 0.2, 5)})
      for (const double sign : {1.0, -1.0})
        rays.push_back({from, {0, 0, -sign * std::pow(10.0, exponent)}, -inf, inf});
  EXPECT_EQ(bed.differences(rays), "");
  for (const Found& found : bed.hits(rays)) {
    hits += found.hit();
    EXPECT_EQ(found.hit(), std::isfinite(found.t)) << found;
  }
  EXPECT_GT(hits, 20u);
}

TEST(RayOrigins, InTheMiddleOfABoxAndAStepFromItsFaces) {
  Bed bed;
  bed.add(box({-1, -1, -1}, {1, 1, 1}));
  ASSERT_EQ(bed.update(), "");
  const double in = std::nextafter(1.0f, 0.0f), out = std::nextafter(1.0f, 2.0f);
  Random random(8);
  std::vector<Ray> inside, outside;
  for (int i = 0; i < 120; ++i) {
    const int axis = i % 3;
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    Ray ray{0.9 * random.in_box(1.0), random.way()};
    if (i < 12) ray.origin = Vec3d(0.0);
    if (i >= 24) ray.origin[axis] = side * in;
    inside.push_back(ray);
    ray.origin[axis] = side * out;
    ray.direction[axis] = side * std::fabs(ray.direction[axis]);
    outside.push_back(ray);
  }
  EXPECT_EQ(bed.differences(inside) + bed.differences(outside), "");
  for (const Found& found : bed.hits(inside)) EXPECT_TRUE(found.hit());
  for (const Found& found : bed.hits(outside)) EXPECT_FALSE(found.hit());
}

}  // namespace
}  // namespace regraft::test
