#include "regraft/shade/lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace regraft::shade {
namespace {

using std::numbers::pi;

/// Points in a row along x on the plane z = 0, from −4 to 4, that face up.
std::unique_ptr<SurfaceLanes> floor_points() {
  auto surface = std::make_unique<SurfaceLanes>();
  surface->active = all_lanes;
  surface->normal.x.fill(0.0f);
  surface->normal.y.fill(0.0f);
  surface->normal.z.fill(1.0f);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    surface->position[0][i] = 8.0 * i / 63.0 - 4.0;
    surface->position[1][i] = 0.5;
    surface->position[2][i] = 0.0;
  }
  return surface;
}

/// W/m² that reach each point from the light's centre.
std::unique_ptr<Illumination> from_centre(const Light& light, const SurfaceLanes& surface) {
  auto out = std::make_unique<Illumination>();
  const auto prepared = prepare_lights({&light, 1});
  illuminate(prepared.at(0), surface, nullptr, *out);
  for (float& value : out->irradiance.value) value *= prepared[0].intensity.x;
  return out;
}

/// The mean over many points of the light.
std::vector<double> averaged(const Light& light, const SurfaceLanes& surface) {
  const auto prepared = prepare_lights({&light, 1});
  const std::uint32_t count = 4096;
  const Sampler sampler(1, count);
  Illumination out;
  PointLanes points;
  std::vector<double> sum(lane_count, 0.0);
  for (std::uint32_t s = 0; s < count; ++s) {
    sampler.points(0, 0, s, 8, points);
    illuminate(prepared.at(0), surface, &points, out);
    for (std::uint32_t i = 0; i < lane_count; ++i)
      sum[i] += double(out.irradiance[i] * prepared[0].intensity.x) / count;
  }
  return sum;
}

Light lamp(LightKind kind, const Vec3d& at = {0.5, -0.2, 3.0}) {
  Light light;
  light.kind = kind;
  light.position = at;
  light.energy = 100.0f;
  return light;
}

TEST(Lights, APointLightSpreadsItsPowerOverTheSphere) {
  const auto surface = floor_points();
  const auto light = from_centre(lamp(LightKind::point), *surface);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const double x = surface->position[0][i] - 0.5, d2 = x * x + 0.7 * 0.7 + 9.0;
    EXPECT_NEAR(light->irradiance[i], 100.0 / (4 * pi * d2) * 3.0 / std::sqrt(d2), 1e-5);
  }
}

TEST(Lights, ASunGivesItsIrradianceTimesTheCosine) {
  Light sun = lamp(LightKind::sun);
  sun.direction = {0.6, 0.0, -0.8};
  sun.energy = 3.0f;
  const auto light = from_centre(sun, *floor_points());
  for (std::uint32_t i = 0; i < lane_count; ++i) EXPECT_NEAR(light->irradiance[i], 2.4f, 1e-6f);
}

TEST(Lights, ASpotIsAPointLightWithASmoothRim) {
  Light spot = lamp(LightKind::spot, {0.0, 0.5, 3.0});
  spot.spot_angle = float(pi / 3);
  spot.spot_blend = 0.5f;
  const auto surface = floor_points();
  const auto light = from_centre(spot, *surface);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const double x = surface->position[0][i], d2 = x * x + 9.0, cosine = 3.0 / std::sqrt(d2);
    const double edge = std::cos(pi / 6);
    const double s = std::clamp((cosine - edge) / ((1 - edge) * 0.5), 0.0, 1.0);
    EXPECT_NEAR(light->irradiance[i], 100.0 / (4 * pi * d2) * cosine * s * s * (3 - 2 * s), 1e-5);
    EXPECT_EQ(has_lane(light->lit, i), cosine > edge);
  }
}

TEST(Lights, AHardSpotEndsAtItsCone) {
  Light spot = lamp(LightKind::spot, {0.0, 0.5, 3.0});
  spot.spot_blend = 0.0f;
  spot.spot_angle = float(pi / 2);
  const auto surface = floor_points();
  const auto light = from_centre(spot, *surface);
  for (std::uint32_t i = 0; i < lane_count; ++i)
    EXPECT_EQ(has_lane(light->lit, i), std::fabs(surface->position[0][i]) < 3.0) << i;
}

TEST(Lights, AFarAreaLightIsLambertianAndOneSided) {
  Light area = lamp(LightKind::area, {0.0, 0.5, 30.0});
  area.size = {0.1f, 0.1f};
  area.direction = glm::normalize(Vec3d(0.5, 0.0, -1.0));
  const auto surface = floor_points();
  const auto light = from_centre(area, *surface);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const double x = surface->position[0][i], d2 = x * x + 900.0;
    const double emitted = (0.5 * x + 30.0) / std::sqrt(1.25 * d2);
    EXPECT_NEAR(light->irradiance[i], 100.0 / pi * emitted * 30.0 / (d2 * std::sqrt(d2)), 1e-6);
  }
  area.direction = {0.0, 0.0, 1.0};
  EXPECT_EQ(from_centre(area, *surface)->lit, 0u);
}

/// Irradiance of a rectangle at a point under its middle: the exact formula of radiometry, four
/// times that of a corner.
double under_rectangle(double radiance, double a, double b, double h) {
  const double x = a / 2 / h, y = b / 2 / h;
  return 4 * radiance / 2 *
         (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y)));
}

TEST(Lights, TheMeanOverAnAreaLightIsItsExactIrradiance) {
  auto surface = floor_points();
  surface->position[0].fill(0.0);
  Light area = lamp(LightKind::area, {0.0, 0.5, 1.5});
  area.size = {2.0f, 1.0f};
  const double exact = under_rectangle(100.0 / (pi * 2.0), 2.0, 1.0, 1.5);
  EXPECT_NEAR(averaged(area, *surface)[0], exact, 0.005 * exact);
  // The centre alone stands for the light to within a few per cent, even so near, as long as it
  // is not much longer than wide.
  EXPECT_NEAR(from_centre(area, *surface)->irradiance[0], exact, 0.06 * exact);
  area.size = {1.5f, 1.5f};
  const double square = under_rectangle(100.0 / (pi * 2.25), 1.5, 1.5, 1.5);
  EXPECT_NEAR(from_centre(area, *surface)->irradiance[0], square, 0.02 * square);
}

TEST(Lights, TheMeanOverALampIsThatOfItsDisk) {
  auto surface = floor_points();
  surface->position[0].fill(0.0);
  Light point = lamp(LightKind::point, {0.0, 0.5, 1.0});
  point.radius = 0.5f;
  const double exact = 100.0 / (4 * pi) / (1.0 + 0.25);
  EXPECT_NEAR(averaged(point, *surface)[0], exact, 0.005 * exact);
  EXPECT_NEAR(from_centre(point, *surface)->irradiance[0], exact, 1e-4 * exact);
}

TEST(Lights, TheMeanOverASunsDiskIsTheSun) {
  Light sun = lamp(LightKind::sun);
  sun.radius = 0.1f;
  sun.energy = 2.0f;
  sun.direction = {0.0, 0.6, -0.8};
  EXPECT_NEAR(averaged(sun, *floor_points())[5], 1.6, 0.01);
}

TEST(Lights, SamplesOfALampStayWithinIt) {
  const auto surface = floor_points();
  Light point = lamp(LightKind::point);
  point.radius = 0.25f;
  const auto prepared = prepare_lights({&point, 1});
  PointLanes points;
  Illumination out;
  for (std::uint32_t s = 0; s < 16; ++s) {
    Sampler(4, 16).points(0, 0, s, 8, points);
    illuminate(prepared[0], *surface, &points, out);
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      const double dx = out.target[0][i] - 0.5, dy = out.target[1][i] + 0.2,
                   dz = out.target[2][i] - 3.0;
      EXPECT_LE(std::sqrt(dx * dx + dy * dy + dz * dz), 0.25 + 1e-6);
    }
  }
}

TEST(Lights, PointsInsideALampGetFiniteLight) {
  auto surface = floor_points();
  Light point = lamp(LightKind::point, {surface->position[0][10], 0.5, 0.0});
  for (const float radius : {0.0f, 2.0f}) {
    point.radius = radius;
    const auto light = from_centre(point, *surface);
    const std::vector<double> soft = averaged(point, *surface);
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      EXPECT_TRUE(std::isfinite(light->irradiance[i])) << i;
      EXPECT_TRUE(std::isfinite(soft[i])) << i;
    }
  }
}

TEST(Lights, NothingComesFromBehindTheSurface) {
  const auto light = from_centre(lamp(LightKind::point, {0.0, 0.0, -1.0}), *floor_points());
  EXPECT_EQ(light->lit, 0u);
  for (const float value : light->irradiance.value) EXPECT_EQ(value, 0.0f);
}

TEST(Lights, LightsThatCannotShineAreLeftOut) {
  Light dark = lamp(LightKind::point), black = dark, broken = dark;
  dark.energy = 0.0f;
  black.color = Vec3(0.0f);
  broken.energy = std::numeric_limits<float>::quiet_NaN();
  const Light lights[] = {dark, lamp(LightKind::sun), black, broken};
  const auto prepared = prepare_lights(lights);
  ASSERT_EQ(prepared.size(), 1u);
  EXPECT_EQ(prepared[0].light.kind, LightKind::sun);
}

}  // namespace
}  // namespace regraft::shade
