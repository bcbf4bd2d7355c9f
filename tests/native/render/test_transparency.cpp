#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "render/stage.h"

namespace regraft::render {
namespace {

using test::from_above;
using test::plain;
using test::red;
using test::sized;
using test::square;
using test::Stage;

/// Shows colours as they are: a headlight on surfaces that face it.
struct Stack : Stage {
  /// Squares above one another, the first on top, of these materials.
  explicit Stack(const std::vector<Material>& materials) {
    renderer.scene().set_materials(materials);
    for (std::uint32_t i = 0; i < materials.size(); ++i)
      add(square(1.0f, -0.1f * float(i)), Mat4d(1.0), {i});
  }
  float seen(float world = 0.0f) {
    renderer.scene().set_world(Vec3(world));
    return red(picture(from_above(0.5), sized(3, 3)), 1, 1);
  }
};

TEST(Transparency, LayersCoverWhatIsBehindInOrderOfDepth) {
  Stack stack({plain({1.0f, 0, 0}, 0.5f), plain({0.5f, 0, 0}, 0.25f), plain({0.2f, 0, 0})});
  EXPECT_NEAR(stack.seen(), 0.5f + 0.5f * 0.25f * 0.5f + 0.5f * 0.75f * 0.2f, 2e-3f);
}

TEST(Transparency, TheWorldIsSeenThroughTheRest) {
  Stack stack({plain(Vec3(0.0f), 0.25f)});
  EXPECT_NEAR(stack.seen(0.8f), 0.75f * 0.8f, 1e-5f);
}

TEST(Transparency, AlphaIsWhatTheLayersCover) {
  Stack stack({plain(Vec3(1.0f), 0.5f), plain(Vec3(1.0f), 0.5f)});
  RenderSettings settings = sized(3, 3);
  settings.transparent_background = true;
  const Frame frame = stack.picture(from_above(0.5), settings);
  const float* pixel = frame.passes.at("combined").pixel(1, 1);
  EXPECT_NEAR(pixel[3], 0.75f, 1e-6f);
  EXPECT_NEAR(pixel[0], 0.75f, 2e-3f);  // premultiplied
}

TEST(Transparency, TheLastOfEightLayersIsOpaque) {
  std::vector<Material> sheets(12, plain(Vec3(0.0f), 0.1f));
  sheets[7] = plain(Vec3(1.0f), 0.1f);
  Stack stack(sheets);
  EXPECT_NEAR(stack.seen(0.0f), std::pow(0.9f, 7.0f), 2e-3f);
}

TEST(Transparency, SurfacesThatCoincideCountOnce) {
  Stack stack({plain(Vec3(1.0f), 0.5f)});
  stack.add(square(1.0f), Mat4d(1.0), {0});
  EXPECT_NEAR(stack.seen(), 0.5f, 1e-3f);
}

TEST(Transparency, LightIsDimmedByWhatItPasses) {
  Stack stack({plain(Vec3(1.0f), 0.5f), plain(Vec3(1.0f), 0.5f), plain(Vec3(1.0f))});
  Camera between = from_above(0.5);
  between.camera_to_world[3].z = -0.15;
  for (const LightKind kind : {LightKind::sun, LightKind::point}) {
    Light light = test::sun({0.0, 0.0, -1.0}, std::numbers::pi_v<float>);
    if (kind == LightKind::point)
      light = test::point_light(
          {0.0, 0.0, 4.8}, 4.0f * std::numbers::pi_v<float> * std::numbers::pi_v<float> * 25.0f);
    stack.light(light);
    EXPECT_NEAR(red(stack.picture(between, sized(3, 3)), 1, 1), 0.25f, 1e-3f);
  }
}

TEST(Transparency, OpaqueMaterialsAreNotAskedForTheirAlpha) {
  Stack opaque({plain(Vec3(1.0f)), plain(Vec3(1.0f))});
  opaque.light(test::sun({0.0, 0.3, -1.0}, 1.0f));
  const Frame frame = opaque.picture(from_above(0.5), sized(8, 8));
  EXPECT_EQ(frame.statistics.rays_secondary, 0u);
  EXPECT_EQ(frame.statistics.rays_shadow, 64u);
  const auto& texts = frame.statistics.left_out;
  EXPECT_NE(std::find(texts.begin(), texts.end(), "opaque materials: no alpha tests"), texts.end());
}

TEST(Transparency, AMirrorShowsLayersTooAndAnOpaqueWorld) {
  Stack stack({plain(Vec3(1.0f))});
  Material mirror = plain(Vec3(1.0f));
  mirror.metallic = 1.0f;
  mirror.roughness = 0.0f;
  stack.renderer.scene().set_materials({mirror});
  stack.renderer.scene().set_world(Vec3(0.4f));
  stack.light(test::sun({0.0, 0.0, 1.0}, 1.0f));
  RenderSettings settings = sized(3, 3, Shading::reflection);
  settings.transparent_background = true;
  const Frame frame = stack.picture(from_above(0.5), settings);
  EXPECT_NEAR(red(frame, 1, 1), 0.4f, 1e-3f);
  EXPECT_EQ(frame.passes.at("combined").pixel(1, 1)[3], 1.0f);
}

}  // namespace
}  // namespace regraft::render
