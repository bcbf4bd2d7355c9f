#include "regraft/render/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "render/stage.h"

namespace regraft::render {
namespace {

using test::ball;
using test::from_above;
using test::placed;
using test::red;
using test::sized;
using test::square;
using test::Stage;

const std::set<std::string> all_passes{"combined", "depth", "normal", "object_index", "cost"};

bool left_out(const Frame& frame, const std::string& words) {
  const auto& texts = frame.statistics.left_out;
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
    return text.find(words) != std::string::npos;
  });
}

/// A square of object 7, 2 wide, at z = 1, in the middle of a picture 4 wide from z = 10.
Stage& with_square(Stage& stage) {
  stage.add(square(1.0f, 1.0f), Mat4d(1.0), {0}, 7);
  return stage;
}

TEST(Renderer, AnEmptySceneShowsTheWorld) {
  Stage stage;
  stage.renderer.scene().set_world({0.1f, 0.2f, 0.3f});
  RenderSettings settings = sized(16, 9);
  settings.passes = all_passes;
  const Frame frame = stage.picture(from_above(2.0), settings);
  const float* pixel = frame.passes.at("combined").pixel(15, 8);
  EXPECT_EQ(std::vector<float>(pixel, pixel + 4), (std::vector<float>{0.1f, 0.2f, 0.3f, 1.0f}));
  EXPECT_EQ(frame.passes.at("depth").pixel(3, 3)[0], std::numeric_limits<float>::infinity());
  EXPECT_EQ(frame.passes.at("normal").pixel(3, 3)[2], 0.0f);
  EXPECT_FALSE(frame.cancelled);
}

TEST(Renderer, TheDataPassesSayWhatIsThere) {
  Stage stage;
  RenderSettings settings = sized(16, 16);
  settings.passes = all_passes;
  const Frame frame = with_square(stage).picture(from_above(2.0), settings);
  EXPECT_FLOAT_EQ(frame.passes.at("depth").pixel(8, 8)[0], 9.0f);
  EXPECT_EQ(frame.passes.at("object_index").pixel(8, 8)[0], 7.0f);
  EXPECT_EQ(frame.passes.at("object_index").pixel(0, 0)[0], 0.0f);
  EXPECT_FLOAT_EQ(frame.passes.at("normal").pixel(8, 8)[2], 1.0f);
  EXPECT_GE(frame.passes.at("cost").pixel(8, 8)[0], 1.0f);
}

TEST(Renderer, OnlyThePassesAskedForComeBack) {
  Stage stage;
  RenderSettings settings = sized(8, 8);
  settings.passes = {"depth"};
  const Frame frame = with_square(stage).picture(from_above(2.0), settings);
  EXPECT_EQ(frame.passes.size(), 1u);
  EXPECT_EQ(frame.passes.at("depth").channels, 1u);
  EXPECT_EQ(frame.statistics.rays_shadow, 0u);
  EXPECT_TRUE(left_out(frame, "nothing shaded"));
}

TEST(Renderer, ATransparentBackgroundIsEmptyAndSurfacesAreNot) {
  Stage stage;
  stage.renderer.scene().set_world(Vec3(0.5f));
  RenderSettings settings = sized(16, 16);
  settings.transparent_background = true;
  for (const Shading shading : {Shading::clay, Shading::occlusion, Shading::direct}) {
    settings.shading = shading;
    Stage fresh;
    fresh.renderer.scene().set_world(Vec3(0.5f));
    const Frame frame = with_square(fresh).picture(from_above(2.0), settings);
    const float* outside = frame.passes.at("combined").pixel(0, 0);
    EXPECT_EQ(std::vector<float>(outside, outside + 4), std::vector<float>(4, 0.0f));
    EXPECT_EQ(frame.passes.at("combined").pixel(8, 8)[3], 1.0f);
    EXPECT_GT(red(frame, 8, 8), 0.3f);
  }
}

TEST(Renderer, WithoutLightsThereIsAHeadlightThatThrowsNoShadow) {
  Stage stage;
  const Frame frame = with_square(stage).picture(from_above(2.0), sized(16, 16));
  EXPECT_NEAR(red(frame, 8, 8), 1.0f, 1e-3f);
  EXPECT_EQ(frame.statistics.rays_shadow, 0u);
  EXPECT_TRUE(left_out(frame, "no lights"));
  EXPECT_TRUE(left_out(frame, "no alpha tests"));
  EXPECT_TRUE(left_out(frame, "normals not read"));
}

TEST(Renderer, LightsOfNoEffectCastNoRays) {
  Stage stage;
  with_square(stage);
  Light below = test::point_light({0.0, 0.0, -5.0}, 100.0f);
  Light dark = test::point_light({0.0, 0.0, 5.0}, 0.0f);
  Light spot = test::point_light({0.0, 0.0, 5.0}, 100.0f);
  spot.kind = LightKind::spot;
  spot.direction = {0.0, 0.0, 1.0};
  stage.renderer.scene().set_lights({below, dark, spot});
  const Frame frame = stage.picture(from_above(2.0), sized(16, 16));
  EXPECT_EQ(frame.statistics.rays_shadow, 0u);
  EXPECT_EQ(red(frame, 8, 8), 0.0f);
  EXPECT_FALSE(left_out(frame, "no lights"));
}

TEST(Renderer, RaysAreCountedByWhatTheyAreFor) {
  Stage stage;
  with_square(stage).light(test::point_light({0.0, 0.0, 5.0}, 100.0f));
  const Frame frame = stage.picture(from_above(2.0), sized(16, 16));
  EXPECT_EQ(frame.statistics.rays_primary, 256u);
  EXPECT_EQ(frame.statistics.rays_shadow, 64u);
  EXPECT_EQ(frame.statistics.rays_secondary, 0u);
  EXPECT_GT(frame.statistics.triangle_tests, 0u);
}

TEST(Renderer, ObservedCostDoesNotDependOnHowMuchOfThePictureIsEmpty) {
  Stage stage;
  stage.add(ball(16));
  const double near = stage.picture(from_above(1.0), sized(64, 64)).statistics.observed_cost;
  const double far = stage.picture(from_above(4.0), sized(256, 256)).statistics.observed_cost;
  EXPECT_GT(near, 5.0);
  EXPECT_NEAR(far, near, 0.05 * near);
}

TEST(Renderer, TracingAStaleSceneIsRefused) {
  Stage stage;
  with_square(stage).picture(from_above(2.0), sized(8, 8));
  stage.renderer.scene().set_transform(0, placed({0.0, 0.0, 1.0}));
  EXPECT_THROW(stage.renderer.render(from_above(2.0), sized(8, 8)), std::logic_error);
  EXPECT_THROW(stage.renderer.tracer(), std::logic_error);
  stage.renderer.update({});
  EXPECT_NO_THROW(stage.renderer.render(from_above(2.0), sized(8, 8)));
}

TEST(Renderer, NewLightsAndMaterialsNeedNoUpdate) {
  Stage stage;
  with_square(stage).picture(from_above(2.0), sized(8, 8));
  stage.renderer.scene().set_materials({test::plain({0.25f, 0.0f, 0.0f})});
  const Frame frame = stage.renderer.render(from_above(2.0), sized(8, 8));
  EXPECT_NEAR(red(frame, 4, 4), 0.25f, 1e-3f);
}

TEST(Renderer, AnUpdateIsReportedByOneFrameOnly) {
  Stage stage;
  with_square(stage);
  stage.renderer.update({});
  const Frame first = stage.renderer.render(from_above(2.0), sized(8, 8));
  const Frame second = stage.renderer.render(from_above(2.0), sized(8, 8));
  EXPECT_GT(first.statistics.update_ms, 0.0);
  EXPECT_EQ(second.statistics.update_ms, 0.0);
  EXPECT_EQ(second.statistics.triangles, first.statistics.triangles);
  EXPECT_TRUE(left_out(second, "nothing changed since the last frame"));
}

TEST(Renderer, ShadingNormalsFollowADeformation) {
  Stage stage;
  test::Shape shape = square(1.0f);
  shape.smooth = true;
  stage.add(shape);
  RenderSettings settings = sized(8, 8);
  settings.passes = {"normal"};
  stage.picture(from_above(1.0), settings);
  for (Vec3& v : shape.vertices) v.z = v.x;
  stage.renderer.scene().set_vertices(0, shape.vertices);
  const Frame frame = stage.picture(from_above(1.0), settings);
  const float* normal = frame.passes.at("normal").pixel(4, 4);
  EXPECT_NEAR(normal[0], -std::sqrt(0.5f), 1e-5f);
  EXPECT_NEAR(normal[2], std::sqrt(0.5f), 1e-5f);
}

TEST(Renderer, NormalsFaceTheViewerFromBothSides) {
  Stage stage;
  with_square(stage);
  RenderSettings settings = sized(8, 8);
  settings.passes = {"normal"};
  const Frame above = stage.picture(from_above(1.0), settings);
  const Frame below =
      stage.picture(test::perspective({0.0, 0.0, -5.0}, {0.0, 0.0, 0.0}, 0.1), settings);
  EXPECT_FLOAT_EQ(above.passes.at("normal").pixel(4, 4)[2], 1.0f);
  EXPECT_FLOAT_EQ(below.passes.at("normal").pixel(4, 4)[2], -1.0f);
}

TEST(Renderer, ClayIsBrightestFacingTheViewerAndReadsNoLights) {
  Stage stage;
  stage.add(ball(32, 1.0f, true));
  stage.light(test::point_light({5.0, 0.0, 0.0}, 1e6f));
  const Frame frame = stage.picture(from_above(1.2), sized(65, 65, Shading::clay));
  EXPECT_NEAR(red(frame, 32, 32), 0.6f, 1e-2f);
  EXPECT_LT(red(frame, 58, 32), 0.3f);
  EXPECT_NEAR(red(frame, 20, 32), red(frame, 44, 32), 1e-3f);
  EXPECT_EQ(frame.statistics.rays_shadow, 0u);
}

TEST(Renderer, TheHeatMapCoversEverything) {
  Stage stage;
  stage.add(ball(32));
  const Frame frame = stage.picture(from_above(2.0), sized(32, 32, Shading::cost));
  EXPECT_GT(red(frame, 16, 16), red(frame, 0, 0));
  EXPECT_EQ(frame.passes.at("combined").pixel(0, 0)[3], 1.0f);
}

}  // namespace
}  // namespace regraft::render
