#include <gtest/gtest.h>

#include "render/stage.h"

// Catalogue D and I: pictures of scenes far away, and of lights and sizes at their limits.

namespace regraft::render {
namespace {

using test::placed;
using test::sized;
using test::Stage;

/// A floor, two balls, a lamp and the sun, all `away` from the origin, `size` times as large.
Frame picture(const Vec3d& away, double size) {
  Stage stage;
  const auto put = [&](const Vec3d& p, double s) {
    return placed(away + size * p, Vec3d(size * s));
  };
  stage.add(test::square(6.0f), put({0, 0, 0}, 1.0));
  stage.add(test::ball(12), put({-1.2, 0, 1}, 1.0));
  stage.add(test::ball(24, 1.0f, true), put({1.2, 0.5, 1}, 1.0));
  // The light of a lamp falls with the square of its distance.
  stage.renderer.scene().set_lights(
      {test::point_light(away + size * Vec3d(-3, -3, 5), float(300.0 * size * size)),
       test::sun({0.3, 0.4, -1.0}, 1.0f)});
  Camera camera = test::perspective(size * Vec3d(0.5, -7, 4), size * Vec3d(0, 0, 0.7));
  camera.camera_to_world[3] += glm::dvec4(away, 0.0);
  RenderSettings settings = sized(48, 36);
  settings.passes = {"combined"};
  return stage.picture(camera, settings);
}

/// Pixels of which a channel differs by more than 1/255.
std::size_t changed(const Frame& a, const Frame& b) {
  const auto& p = a.passes.at("combined").pixels;
  const auto& q = b.passes.at("combined").pixels;
  std::size_t sum = 0;
  for (std::size_t i = 0; i < p.size(); i += 4) {
    bool same = true;
    for (std::size_t c = 0; c < 4; ++c) same &= std::fabs(p[i + c] - q[i + c]) <= 1.0f / 255.0f;
    sum += !same;
  }
  return sum;
}

TEST(FarPictures, AMillionAndABillionUnitsAwayTheyAreThoseOfTheOrigin) {
  const Frame here = picture(Vec3d(0.0), 1.0);
  EXPECT_EQ(changed(here, picture({1e6, -1e6, 5e5}, 1.0)), 0u);
  EXPECT_EQ(changed(here, picture({1e9, -1e9, 5e8}, 1.0)), 0u);
}

TEST(FarPictures, AtAMillionthAndATrillionTimesTheSizeTheyAreTheSame) {
  const Frame here = picture(Vec3d(0.0), 1.0);
  EXPECT_EQ(changed(here, picture(Vec3d(0.0), 1e-6)), 0u);
  EXPECT_EQ(changed(here, picture(Vec3d(0.0), 1e12)), 0u);
}

}  // namespace
}  // namespace regraft::render
