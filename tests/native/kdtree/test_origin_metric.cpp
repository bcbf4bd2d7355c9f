#include "regraft/kdtree/origin_metric.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <random>
#include <sstream>

namespace regraft::test {
namespace {

using kdtree::OriginMetric;
using kdtree::visit_probability;

constexpr OriginMetric all_metrics[] = {OriginMetric::sah, OriginMetric::regions6,
                                        OriginMetric::regions26, OriginMetric::faces,
                                        OriginMetric::exact};
constexpr OriginMetric additive_metrics[] = {OriginMetric::sah, OriginMetric::regions6,
                                             OriginMetric::exact};

struct Truth {
  std::string name;
  Aabb origins, box;
  double solid_angle, solid_angle_error, rays, rays_error;
  double exact, regions26, regions6, sah, faces;
};

std::vector<Truth> ground_truth() {
  std::ifstream file(REGRAFT_TEST_DATA "/pn_ground_truth.csv");
  std::vector<Truth> table;
  std::string line;
  for (int row = 0; std::getline(file, line); ++row) {
    if (row < 2) continue;  // what it is, and the names of its columns
    Truth t;
    std::getline(std::istringstream(line), t.name, ',');
    std::istringstream numbers(line.substr(t.name.size() + 1));
    const auto next = [&numbers] {
      std::string cell;
      std::getline(numbers, cell, ',');
      return std::stod(cell);
    };
    for (Vec3* corner : {&t.origins.lo, &t.origins.hi, &t.box.lo, &t.box.hi})
      for (int k = 0; k < 3; ++k) (*corner)[k] = float(next());
    for (double* p : {&t.solid_angle, &t.solid_angle_error, &t.rays, &t.rays_error, &t.exact,
                      &t.regions26, &t.regions6, &t.sah, &t.faces})
      *p = next();
    table.push_back(t);
  }
  return table;
}

/// How many standard errors `p` lies from an estimate; the scene itself has an error of 0.
double z_score(double p, double estimate, double error) {
  return error > 0.0 ? (p - estimate) / error : (p == estimate ? 0.0 : INFINITY);
}

TEST(OriginMetric, ExactAgreesWithTwoMonteCarloEstimatesOf24Cases) {
  const std::vector<Truth> table = ground_truth();
  ASSERT_EQ(table.size(), 24u);
  double square_solid_angle = 0.0;
  double square_rays = 0.0;
  for (const Truth& t : table) {
    const double p = visit_probability(OriginMetric::exact, t.origins, t.box);
    const double z1 = z_score(p, t.solid_angle, t.solid_angle_error);
    const double z2 = z_score(p, t.rays, t.rays_error);
    EXPECT_LT(std::fabs(z1), 2.5) << t.name;
    EXPECT_LT(std::fabs(z2), 2.5) << t.name;
    square_solid_angle += z1 * z1;
    square_rays += z2 * z2;
  }
  EXPECT_LT(std::sqrt(square_solid_angle / 24.0), 1.0);
  EXPECT_LT(std::sqrt(square_rays / 24.0), 1.0);
}

TEST(OriginMetric, EveryMetricAgreesWithTheReferenceImplementation) {
  for (const Truth& t : ground_truth()) {
    const auto off = [&t](OriginMetric metric, double expected) {
      return std::fabs(visit_probability(metric, t.origins, t.box) / expected - 1.0);
    };
    // Coordinates such as 0.7 are rounded to float here, and the thinnest slab is 0.01 thick.
    EXPECT_LT(off(OriginMetric::exact, t.exact), 2e-6) << t.name;
    EXPECT_LT(off(OriginMetric::regions26, t.regions26), 2e-6) << t.name;
    EXPECT_LT(off(OriginMetric::regions6, t.regions6), 2e-6) << t.name;
    EXPECT_LT(off(OriginMetric::sah, t.sah), 2e-6) << t.name;
    EXPECT_LT(off(OriginMetric::faces, t.faces), 2e-6) << t.name;
  }
}

TEST(OriginMetric, GivesTheWorkedExamples) {
  const Aabb cube{Vec3(0), Vec3(1)};
  const auto expect = [](const Aabb& s, const Aabb& n, std::array<double, 4> p) {
    EXPECT_NEAR(visit_probability(OriginMetric::exact, s, n), p[0], 6e-8);
    EXPECT_NEAR(visit_probability(OriginMetric::regions26, s, n), p[1], 6e-8);
    EXPECT_NEAR(visit_probability(OriginMetric::regions6, s, n), p[2], 6e-8);
    EXPECT_NEAR(visit_probability(OriginMetric::sah, s, n), p[3], 5e-7);
  };
  expect(cube, {Vec3(.25f), Vec3(.75f)}, {.268398430, .290111525, .25, .25});
  expect(cube, {Vec3(0), Vec3(.5f)}, {.217985382, .217926509, .21875, .25});
  expect(cube, {Vec3(0), Vec3(1, 1, .5f)}, {.623980509, .647583618, .625, .666667});
  expect(cube, {Vec3(0), Vec3(.02f, 1, 1)}, {.185541437, .186983777, .185540541, .346667});
  expect({Vec3(0), Vec3(10, 6, 3)}, {Vec3(0), Vec3(10, 6, .1f)},
         {.302056869, .354754857, .305889724, .570370});
}

/// Boxes N in M in S, often touching, sometimes flat.
class Nest {
 public:
  explicit Nest(std::uint32_t seed) : random_(seed) {
    for (int k = 0; k < 3; ++k) {
      const float size = std::exp2(uniform(-4.0f, 4.0f));
      origins.lo[k] = uniform(-5.0f, 5.0f);
      origins.hi[k] = origins.lo[k] + size;
    }
    outer = inside(origins);
    inner = inside(outer);
    axis = int(random_() % 3);
    plane = coordinate(outer, axis);
  }
  float uniform(float lo, float hi) {
    return std::uniform_real_distribution<float>(lo, hi)(random_);
  }

  Aabb origins, outer, inner;
  int axis;
  float plane;  ///< in `outer` across `axis`

 private:
  float coordinate(const Aabb& in, int k) {
    const std::uint32_t kind = random_() % 8;
    if (kind < 2) return kind == 0 ? in.lo[k] : in.hi[k];
    return std::clamp(in.lo[k] + uniform(0, 1) * (in.hi[k] - in.lo[k]), in.lo[k], in.hi[k]);
  }
  Aabb inside(const Aabb& in) {
    Aabb box;
    for (int k = 0; k < 3; ++k) {
      const float a = coordinate(in, k);
      const float b = coordinate(in, k);
      box.lo[k] = std::min(a, b);
      box.hi[k] = std::max(a, b);
    }
    return box;
  }
  std::mt19937 random_;
};

RC_GTEST_PROP(OriginMetric, IsAProbabilityAndThatOfTheWholeIsOne, (std::uint32_t seed)) {
  const Nest nest(seed);
  for (const OriginMetric metric : all_metrics) {
    RC_ASSERT(std::fabs(visit_probability(metric, nest.origins, nest.origins) - 1.0) < 1e-12);
    const double p = visit_probability(metric, nest.origins, nest.inner);
    RC_ASSERT((p >= 0.0 && p <= 1.0));
  }
}

RC_GTEST_PROP(OriginMetric, DoesNotFallAsTheBoxGrows, (std::uint32_t seed)) {
  const Nest nest(seed);
  for (const OriginMetric metric : additive_metrics)
    RC_ASSERT(visit_probability(metric, nest.origins, nest.inner) <=
              visit_probability(metric, nest.origins, nest.outer) + 1e-14);
}

RC_GTEST_PROP(OriginMetric, OfBothSidesIsThatOfTheWholeAndOfThePlane, (std::uint32_t seed)) {
  const Nest nest(seed);
  Aabb left = nest.outer;
  Aabb right = nest.outer;
  left.hi[nest.axis] = right.lo[nest.axis] = nest.plane;
  Aabb plane = left;
  plane.lo[nest.axis] = nest.plane;
  for (const OriginMetric metric : additive_metrics) {
    const auto p = [&](const Aabb& box) { return visit_probability(metric, nest.origins, box); };
    RC_ASSERT(std::fabs(p(left) + p(right) - p(nest.outer) - p(plane)) < 1e-12);
  }
}

RC_GTEST_PROP(OriginMetric, IsTheSameScaledMovedTurnedAndMirrored, (std::uint32_t seed)) {
  Nest nest(seed);
  const int turn = int(seed % 3);
  const float scale = std::ldexp(1.0f, int(seed % 41) - 20);  // exact, so are the comparisons
  const auto moved = [&](const Aabb& b) {
    Aabb r;
    for (int k = 0; k < 3; ++k) {
      r.lo[k] = -scale * b.hi[(k + turn) % 3];
      r.hi[k] = -scale * b.lo[(k + turn) % 3];
    }
    return r;
  };
  for (const OriginMetric metric : all_metrics)
    RC_ASSERT(std::fabs(visit_probability(metric, nest.origins, nest.inner) -
                        visit_probability(metric, moved(nest.origins), moved(nest.inner))) < 1e-12);
}

/// Length inside `box` of the line through `p` along the unit vector `d`.
double chord(const Aabb& box, const Vec3d& p, const Vec3d& d) {
  double near = -INFINITY;
  double far = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const double a = (double(box.lo[k]) - p[k]) / d[k];
    const double b = (double(box.hi[k]) - p[k]) / d[k];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return std::max(0.0, far - near);
}

/// Mean chord of `origins` over lines that hit `box`: each of its points, by the cosine.
double mean_chord(const Aabb& origins, const Aabb& box, int count, double& error) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit;
  const Vec3d e = box.extents();
  double sum = 0.0;
  double square = 0.0;
  for (int n = 0; n < count; ++n) {
    double pick = unit(random) * half_area(box);
    int k = 0;
    while (k < 2 && pick >= e[(k + 1) % 3] * e[(k + 2) % 3]) {
      pick -= e[(k + 1) % 3] * e[(k + 2) % 3];
      ++k;
    }
    Vec3d p = Vec3d(box.lo) + Vec3d(unit(random), unit(random), unit(random)) * e;
    p[k] = box.lo[k];
    const double turn = 6.283185307179586 * unit(random);
    const double sine = std::sqrt(unit(random));
    Vec3d d(0.0);
    d[k] = std::sqrt(1.0 - sine * sine);
    d[(k + 1) % 3] = sine * std::cos(turn);
    d[(k + 2) % 3] = sine * std::sin(turn);
    if (unit(random) < 0.5) p[k] = box.hi[k];
    const double length = chord(origins, p, d);
    sum += length;
    square += length * length;
  }
  const double mean = sum / count;
  error = std::sqrt((square / count - mean * mean) / count);
  return mean;
}

TEST(OriginMetric, ExactIsTheMeanChordOfTheSceneOverLinesThatHitTheBox) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const Nest nest(seed);
    if (half_area(nest.outer) <= 0.0) continue;
    double error = 0.0;
    const double length = mean_chord(nest.origins, nest.outer, 20000, error);
    const Vec3d s = nest.origins.extents();
    const Vec3d n = nest.outer.extents();
    const double volume = s.x * s.y * s.z;
    const double per_length = 2.0 * half_area(nest.outer) / (8.0 * volume);
    const double expected = n.x * n.y * n.z / (2.0 * volume) + per_length * length;
    EXPECT_NEAR(visit_probability(OriginMetric::exact, nest.origins, nest.outer), expected,
                4.0 * per_length * error + 1e-12)
        << seed;
  }
}

TEST(OriginMetric, OfABoxTooSmallForTheClosedFormGoesOverSmoothly) {
  for (const Vec3& at : {Vec3(0.0f), Vec3(0.5f), Vec3(0.0f, 0.25f, 0.5f)}) {
    const Aabb room{-at, Vec3(1) - at};  // the box lies at 0, where floats are fine
    const float edge = std::ldexp(1.0f, -15);
    const auto per_area = [&](float size) {
      return visit_probability(OriginMetric::exact, room, {Vec3(0), Vec3(size)}) / (size * size);
    };
    EXPECT_NEAR(per_area(0.999f * edge) / per_area(edge), 1.0, 1e-4);
    // Far below, the error of the closed form would be larger than the value.
    EXPECT_NEAR(per_area(1e-9f) / per_area(1e-8f), 1.0, 1e-6);
  }
}

TEST(OriginMetric, TakesScenesOfAnySizeAndFlatOnes) {
  for (const float size : {1e-30f, 1e-6f, 1e12f, 1e30f, 3e38f}) {
    const Aabb room{Vec3(0), Vec3(size)};
    const Aabb corner{Vec3(0), Vec3(0.5f * size)};
    EXPECT_NEAR(visit_probability(OriginMetric::exact, room, corner), .217985382, 1e-8);
    EXPECT_NEAR(visit_probability(OriginMetric::regions6, room, corner), .21875, 1e-8);
    EXPECT_NEAR(visit_probability(OriginMetric::regions26, room, corner), .217926509, 1e-8);
  }
  const Aabb flat{Vec3(0), Vec3(2, 2, 0)};
  const Aabb line{Vec3(0), Vec3(2, 0, 0)};
  const Aabb point{Vec3(1), Vec3(1)};
  for (const OriginMetric metric : all_metrics) {
    EXPECT_EQ(visit_probability(metric, flat, {Vec3(0), Vec3(1, 1, 0)}), 0.25);
    EXPECT_EQ(visit_probability(metric, line, {Vec3(0), Vec3(1, 0, 0)}), 0.5);
    EXPECT_EQ(visit_probability(metric, point, point), 1.0);
  }
}

TEST(OriginMetric, ClipsABoxThatReachesOutAndIsZeroOutside) {
  const Aabb room{Vec3(0), Vec3(1)};
  for (const OriginMetric metric : all_metrics) {
    EXPECT_EQ(visit_probability(metric, room, {Vec3(-3), Vec3(0.5f)}),
              visit_probability(metric, room, {Vec3(0), Vec3(0.5f)}));
    EXPECT_EQ(visit_probability(metric, room, {Vec3(-3), Vec3(7)}), 1.0);
    EXPECT_EQ(visit_probability(metric, room, {Vec3(2), Vec3(3)}), 0.0);
  }
}

TEST(OriginMetric, OfAFlatBoxIsThatOfItsTwoSides) {
  const Aabb room{Vec3(0), Vec3(1)};
  const Aabb floor{Vec3(0.25f, 0.25f, 0), Vec3(0.75f, 0.75f, 0)};
  const Aabb middle{Vec3(0.25f, 0.25f, 0.5f), Vec3(0.75f, 0.75f, 0.5f)};
  EXPECT_NEAR(visit_probability(OriginMetric::exact, room, floor), .0495194342981824, 1e-14);
  EXPECT_NEAR(visit_probability(OriginMetric::exact, room, middle), .0741870300439481, 1e-14);
  const Aabb edge{Vec3(0), Vec3(1, 0, 0)};
  for (const OriginMetric metric : all_metrics)
    EXPECT_EQ(visit_probability(metric, room, edge), 0.0);
}

}  // namespace
}  // namespace regraft::test
