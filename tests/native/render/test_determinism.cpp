#include <gtest/gtest.h>

#include "render/stage.h"

namespace regraft::render {
namespace {

using test::ball;
using test::placed;
using test::same_pixels;
using test::sized;
using test::square;
using test::Stage;

const std::set<std::string> data_passes{"combined", "depth", "normal", "object_index"};

/// Everything at once: smooth and flat, glossy, metallic and transparent, five kinds of light.
void furnish(Stage& stage) {
  Material glass = test::plain({0.2f, 0.5f, 0.9f}, 0.4f);
  Material metal = test::plain({0.9f, 0.7f, 0.3f});
  metal.metallic = 1.0f;
  metal.roughness = 0.1f;
  stage.renderer.scene().set_materials({test::plain(Vec3(0.8f)), glass, metal});
  stage.add(square(6.0f), Mat4d(1.0), {0}, 1);
  stage.add(ball(12, 1.0f, true), placed({-1.5, 0.0, 1.0}), {1}, 2);
  stage.add(ball(12), placed({0.5, 0.5, 1.0}, {1.0, 0.7, 1.1}), {2}, 3);
  stage.add(ball(40, 1.0f, true), placed({2.5, -0.5, 0.8}, {-0.8, 0.8, 0.8}), {0}, 4);
  Light lamp = test::point_light({-3.0, -3.0, 5.0}, 300.0f);
  lamp.radius = 0.4f;
  Light spot = test::point_light({3.0, -2.0, 5.0}, 500.0f);
  spot.kind = LightKind::spot;
  spot.direction = glm::normalize(Vec3d(-0.4, 0.3, -1.0));
  Light area = test::point_light({0.0, 4.0, 4.0}, 200.0f);
  area.kind = LightKind::area;
  area.direction = glm::normalize(Vec3d(0.0, -1.0, -1.0));
  Light sky = test::sun({0.2, 0.5, -1.0}, 0.5f);
  sky.radius = 0.05f;
  stage.renderer.scene().set_lights({lamp, spot, area, sky});
  stage.renderer.scene().set_world({0.05f, 0.06f, 0.1f});
}

Camera view() {
  return test::perspective({0.5, -7.0, 4.0}, {0.5, 0.0, 0.7}, 0.5);
}

RenderSettings asked(Shading shading, std::uint32_t samples) {
  RenderSettings settings = sized(53, 41, shading);
  settings.samples = samples;
  settings.passes = data_passes;
  return settings;
}

void expect_same(const Frame& a, const Frame& b, const std::string& what) {
  ASSERT_EQ(a.passes.size(), b.passes.size());
  for (const auto& [name, image] : a.passes)
    EXPECT_TRUE(same_pixels(image, b.passes.at(name))) << what << ": " << name;
}

Frame furnished_picture(unsigned threads, simd::Isa isa, const RenderSettings& settings) {
  Stage stage(threads, isa);
  furnish(stage);
  return stage.picture(view(), settings);
}

const std::pair<Shading, std::uint32_t> modes[] = {
    {Shading::clay, 1},   {Shading::occlusion, 1},  {Shading::occlusion, 3}, {Shading::direct, 1},
    {Shading::direct, 5}, {Shading::reflection, 1}, {Shading::reflection, 3}};

TEST(Determinism, ThePictureDoesNotDependOnTheNumberOfThreads) {
  for (const auto& [shading, samples] : modes) {
    const RenderSettings settings = asked(shading, samples);
    const Frame one = furnished_picture(1, simd::best_isa(), settings);
    expect_same(one, furnished_picture(2, simd::best_isa(), settings), "2 threads");
    expect_same(one, furnished_picture(5, simd::best_isa(), settings), "5 threads");
  }
}

TEST(Determinism, ThePictureDoesNotDependOnTheInstructionSet) {
  for (const auto& [shading, samples] : modes) {
    const RenderSettings settings = asked(shading, samples);
    const Frame scalar = furnished_picture(2, simd::Isa::scalar, settings);
    for (const simd::Isa isa : simd::available_isas())
      expect_same(scalar, furnished_picture(2, isa, settings), std::string(simd::name(isa)));
  }
}

TEST(Determinism, ThePictureDoesNotDependOnTheLayout) {
  const RenderSettings settings = asked(Shading::reflection, 2);
  Stage stage;
  furnish(stage);
  const Frame two_level = stage.picture(view(), settings);
  accel::UpdateOptions flat;
  flat.layout = accel::Layout::flat;
  stage.renderer.update(flat);
  expect_same(two_level, stage.renderer.render(view(), settings), "flat");
}

TEST(Determinism, ARegionIsTheCropOfTheWholeImage) {
  Stage stage;
  furnish(stage);
  for (const auto& [shading, samples] : modes) {
    RenderSettings settings = asked(shading, samples);
    const Frame whole = stage.picture(view(), settings);
    for (const auto& region : {std::array<std::uint32_t, 4>{5, 3, 38, 30},
                               {16, 8, 24, 16},
                               {52, 40, 53, 41},
                               {0, 0, 1, 41}}) {
      settings.region = region;
      const Frame part = stage.renderer.render(view(), settings);
      for (const auto& [name, image] : part.passes) {
        ASSERT_EQ(image.width, region[2] - region[0]);
        ASSERT_EQ(image.height, region[3] - region[1]);
        for (std::uint32_t y = 0; y < image.height; ++y) {
          const float* row = whole.passes.at(name).pixel(region[0], region[1] + y);
          EXPECT_TRUE(std::equal(row, row + image.width * image.channels, image.pixel(0, y)))
              << name << " row " << y;
        }
      }
    }
  }
}

TEST(Determinism, TheSeedChangesTheNoiseAndNothingElse) {
  Stage stage;
  furnish(stage);
  RenderSettings settings = asked(Shading::direct, 4);
  const Frame first = stage.picture(view(), settings);
  expect_same(first, stage.renderer.render(view(), settings), "same seed");
  settings.seed = 0x100000000u;
  const Frame second = stage.renderer.render(view(), settings);
  EXPECT_FALSE(same_pixels(first.passes.at("combined"), second.passes.at("combined")));
  settings.samples = 1;
  const Frame centred = stage.renderer.render(view(), settings);
  settings.seed = 0;
  expect_same(centred, stage.renderer.render(view(), settings),
              "one sample goes through the centre");
}

TEST(Determinism, ManySamplesAgreeWhateverTheSeed) {
  Stage stage;
  furnish(stage);
  RenderSettings settings = sized(24, 18, Shading::direct);
  settings.samples = 256;
  const Frame first = stage.picture(view(), settings);
  settings.seed = 99;
  const Frame second = stage.renderer.render(view(), settings);
  double sum = 0.0;
  const auto& a = first.passes.at("combined").pixels;
  const auto& b = second.passes.at("combined").pixels;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * double(a[i] - b[i]);
  EXPECT_LT(std::sqrt(sum / double(a.size())), 0.03);
}

TEST(Determinism, OnePixelAndOneColumnAreImagesToo) {
  Stage stage;
  furnish(stage);
  for (const auto& [width, height] : {std::pair{1u, 1u}, {1u, 37u}, {37u, 1u}}) {
    RenderSettings settings = sized(width, height, Shading::reflection);
    settings.passes = data_passes;
    const Frame frame = stage.picture(view(), settings);
    EXPECT_EQ(frame.passes.at("combined").pixels.size(), std::size_t(width) * height * 4);
    EXPECT_TRUE(test::all_finite(frame.passes.at("combined")));
    EXPECT_EQ(frame.statistics.rays_primary, std::uint64_t(width) * height);
  }
}

TEST(Determinism, NoModeMakesNumbersThatAreNone) {
  Stage stage;
  furnish(stage);
  for (const auto& [shading, samples] : modes)
    EXPECT_TRUE(
        test::all_finite(stage.picture(view(), asked(shading, samples)).passes.at("combined")));
}

}  // namespace
}  // namespace regraft::render
