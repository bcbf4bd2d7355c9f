#include "regraft/shade/occlusion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/stage.h"

namespace regraft::shade {
namespace {

using test::from_above;
using test::placed;
using test::red;
using test::sized;
using test::square;
using test::Stage;

render::RenderSettings many_rays(std::uint32_t width, std::uint32_t height) {
  render::RenderSettings settings = sized(width, height, Shading::occlusion);
  settings.samples = 512;
  return settings;
}

TEST(Occlusion, TheReachFollowsTheSceneAndIgnoresAThinAxis) {
  EXPECT_FLOAT_EQ(occlusion_radius(Vec3d(0.0), Vec3d(8.0)), 2.0f);
  EXPECT_FLOAT_EQ(occlusion_radius(Vec3d(0.0), Vec3d(100.0, 100.0, 0.0)),
                  float(0.25 * std::cbrt(100.0 * 100.0 * 1.0)));
  EXPECT_EQ(occlusion_radius(Vec3d(1.0), Vec3d(-1.0)), 0.0f);
  EXPECT_EQ(occlusion_radius(Vec3d(3.0), Vec3d(3.0)), 0.0f);
}

TEST(Occlusion, AnOpenPlaneIsWhite) {
  Stage stage;
  stage.add(square(5.0f));
  const render::Frame frame = stage.picture(from_above(4.0), sized(32, 32, Shading::occlusion));
  for (std::uint32_t i = 0; i < 32; ++i) EXPECT_EQ(red(frame, i, i), 1.0f);
  EXPECT_EQ(frame.statistics.rays_secondary, 32u * 32u * occlusion_rays);
}

TEST(Occlusion, AWallAtTheFootOfAPlaneTakesHalfTheSky) {
  // At the wall, half of the cosine-weighted hemisphere looks into it.
  Stage stage;
  stage.add(square(10.0f));
  const test::Shape wall{{{0, -10, 0}, {0, 10, 0}, {0, 10, 10}, {0, -10, 10}},
                         {{0, 1, 2}, {0, 2, 3}}};
  stage.add(wall);
  Camera camera = from_above(0.01);
  camera.camera_to_world[3] = {-0.0101, 0.0, 9.0, 1.0};
  EXPECT_NEAR(red(stage.picture(camera, many_rays(8, 8)), 7, 4), 0.5f, 0.02f);
}

TEST(Occlusion, ACeilingOccludesInProportionToItsNearness) {
  // A ceiling at height h stops a ray of angle θ if its length, even over 0 … R, exceeds
  // h / cos θ: openness is the mean of min(1, h / (R cos θ)) over the cosine-weighted
  // hemisphere, for h < R: 2·h/R − (h/R)².
  Stage stage;
  stage.add(square(50.0f));
  stage.add(square(50.0f, 1.0f));
  const double reach = 0.25 * std::cbrt(100.0 * 100.0 * 1.0);
  Camera camera = from_above(1.0, 0.5);
  const double h = 1.0 / reach;
  const render::Frame frame = stage.picture(camera, many_rays(4, 4));
  EXPECT_NEAR(red(frame, 2, 2), 2 * h - h * h, 0.02);
}

TEST(Occlusion, FewSamplesStillGetEightRaysAPixel) {
  Stage stage;
  stage.add(square(5.0f));
  for (const std::uint32_t samples : {1u, 2u, 3u, 8u, 20u}) {
    render::RenderSettings settings = sized(8, 8, Shading::occlusion);
    settings.samples = samples;
    const render::Frame frame = stage.picture(from_above(1.0), settings);
    EXPECT_GE(frame.statistics.rays_secondary, 64u * occlusion_rays);
    EXPECT_LT(frame.statistics.rays_secondary, 64u * (occlusion_rays + samples));
  }
}

TEST(Occlusion, FacetsOfASmoothBodyDoNotOccludeEachOther) {
  Stage stage;
  stage.add(test::ball(8, 1.0f, true));
  const render::Frame frame = stage.picture(test::perspective({4.0, -3.0, 2.0}, Vec3d(0.0), 0.1),
                                            sized(32, 32, Shading::occlusion));
  for (std::uint32_t y = 0; y < 32; ++y)
    for (std::uint32_t x = 0; x < 32; ++x) EXPECT_GE(red(frame, x, y), 0.85f);
}

}  // namespace
}  // namespace regraft::shade
