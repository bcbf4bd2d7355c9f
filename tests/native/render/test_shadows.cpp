// Where light arrives, on scenes whose answer is known without tracing.

#include <gtest/gtest.h>

#include <numbers>

#include "render/stage.h"

namespace regraft::render {
namespace {

using test::ball;
using test::from_above;
using test::placed;
using test::point_light;
using test::red;
using test::sized;
using test::square;
using test::Stage;

constexpr float pi = std::numbers::pi_v<float>;

TEST(Shadows, ASphereOverAPlaneShadowsADisk) {
  // Light at height 6, sphere of radius 1 at height 3 below it: tangents to the sphere meet the
  // plane at 6·tan(asin(1/3)) from its foot.
  Stage stage;
  stage.add(square(10.0f));
  stage.add(ball(96), placed({0.0, 0.0, 3.0}));
  stage.light(point_light({0.0, 0.0, 6.0}, 100.0f));
  Camera below = from_above(4.0);
  below.camera_to_world[3].z = 1.0;
  const Frame frame = stage.picture(below, sized(101, 101));
  const double radius = 6.0 * std::tan(std::asin(1.0 / 3.0));
  for (std::uint32_t y = 0; y < 101; ++y)
    for (std::uint32_t x = 0; x < 101; ++x) {
      const double r = std::hypot((x + 0.5) * 8 / 101 - 4, (y + 0.5) * 8 / 101 - 4);
      if (r < radius - 0.06) {
        EXPECT_EQ(red(frame, x, y), 0.0f) << x << ' ' << y;
      }
      if (r > radius + 0.01) {
        EXPECT_GT(red(frame, x, y), 0.0f) << x << ' ' << y;
      }
    }
}

TEST(Shadows, LightsThatCastNoneShineThrough) {
  Stage stage;
  stage.add(square(10.0f));
  stage.add(ball(16), placed({0.0, 0.0, 3.0}));
  Light light = point_light({0.0, 0.0, 6.0}, 100.0f);
  light.cast_shadow = false;
  stage.light(light);
  Camera below = from_above(1.0);
  below.camera_to_world[3].z = 1.0;
  const Frame frame = stage.picture(below, sized(9, 9));
  EXPECT_NEAR(red(frame, 4, 4), 100.0f / (4 * pi * pi * 36.0f), 1e-4f);
  EXPECT_EQ(frame.statistics.rays_shadow, 0u);
}

TEST(Shadows, SeveralSamplesSoftenTheEdgeOfALampOfSomeSize) {
  // A lamp of radius ½ at height 4, an edge at x = 1, height 2: along the plane the shadow is
  // full up to 1.5 and gone from 2.5 on.
  Stage stage;
  stage.add(square(10.0f));
  stage.add(square(1.0f, 2.0f));
  Light light = point_light({0.0, 0.0, 4.0}, 100.0f);
  light.radius = 0.5f;
  stage.light(light);
  Camera below = from_above(4.0);
  below.camera_to_world[3].z = 1.0;
  RenderSettings settings = sized(64, 3);
  settings.samples = 64;
  const Frame frame = stage.picture(below, settings);
  const auto at = [&](double x) { return red(frame, std::uint32_t((x + 4.0) * 8.0), 1); };
  EXPECT_EQ(at(0.0), 0.0f);
  EXPECT_EQ(at(1.3), 0.0f);
  const float unshadowed = 100.0f / (4 * pi * pi) * 4.0f / std::pow(16.0f + 4.0f, 1.5f);
  EXPECT_NEAR(at(2.0), 0.5f * unshadowed, 0.1f * unshadowed);
  EXPECT_GT(at(2.3), 0.6f * unshadowed);
  EXPECT_NEAR(at(2.7), 100.0f / (4 * pi * pi) * 4.0f / std::pow(16.0f + 7.4f, 1.5f),
              0.05f * unshadowed);
}

/// A convex body: everything that faces a light sees it, whatever the rounding.
struct Convex {
  const char* name;
  Mat4d at;
  double size;
};

const Convex bodies[] = {
    {"at the origin", Mat4d(1.0), 1.0},
    {"a million away", placed({1e6, -2e6, 3e6}), 1.0},
    {"a billion away", placed({1e9, 2e8, -3e8}), 1.0},
    {"a micrometre", placed(Vec3d(0.0), Vec3d(1e-6)), 1e-6},
    {"huge", placed(Vec3d(0.0), Vec3d(1e12)), 1e12},
    {"flattened", placed({3.0, 2.0, 1.0}, {1.0, 0.02, 1.0}), 1.0},
    {"mirrored", placed({3.0, 2.0, 1.0}, {-1.0, 1.0, 0.5}), 1.0},
    {"flat", placed({3.0, 2.0, 1.0}, {1.0, 1.0, 0.0}), 1.0},
};

/// Pixels that are black though their normals, those of the triangles and the shading ones, face
/// a light: each would be the body shadowing itself.
int self_shadowed(const Convex& body, bool smooth, unsigned rings, Light light) {
  Stage stage;
  stage.add(ball(rings, 1.0f, smooth), body.at);
  const Vec3d middle(body.at[3]);
  const Vec3d aside = glm::normalize(Vec3d(0.3, 1.0, 0.5));
  light.position = middle + 20.0 * body.size * aside;
  light.direction = -aside;
  if (light.kind != LightKind::sun) light.energy = float(1e4 * body.size * body.size);
  stage.light(light);
  RenderSettings settings = sized(64, 64);
  settings.passes = {"combined", "normal"};
  const Camera camera = test::perspective(middle + body.size * Vec3d(4.0, 1.5, 2.0), middle, 0.3);
  const Frame frame = stage.picture(camera, settings);
  int black = 0;
  for (std::uint32_t y = 0; y < 64; ++y)
    for (std::uint32_t x = 0; x < 64; ++x) {
      const float* n = frame.passes.at("normal").pixel(x, y);
      const double facing = n[0] * aside.x + n[1] * aside.y + n[2] * aside.z;
      black += facing > 0.08 && !(red(frame, x, y) > 0.0f);
    }
  EXPECT_TRUE(test::all_finite(frame.passes.at("combined"))) << body.name;
  return black;
}

TEST(Shadows, NoConvexBodyShadowsItself) {
  for (const Convex& body : bodies)
    for (const LightKind kind : {LightKind::point, LightKind::sun, LightKind::area})
      for (const bool smooth : {false, true})
        for (const unsigned rings : {6u, 100u}) {
          Light light;
          light.kind = kind;
          light.size = Vec2(0.0f);
          EXPECT_EQ(self_shadowed(body, smooth, rings, light), 0)
              << body.name << ", light " << int(kind) << (smooth ? ", smooth, " : ", flat, ")
              << rings << " rings";
        }
}

TEST(Shadows, NoLightLeaksUnderAClosedBox) {
  // A lid whose edges touch the walls exactly, in another mesh: nothing inside may be lit.
  Stage stage;
  const double offset = 1000.0;
  stage.add(square(1.0f), placed({offset, offset, 0.0}));
  stage.add(square(1.0f, 1.0f), placed({offset, offset, 0.0}));
  test::Shape walls;
  walls.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0},
                    {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
  for (unsigned i = 0; i < 4; ++i) {
    const unsigned j = (i + 1) % 4;
    walls.triangles.push_back({i, j, j + 4});
    walls.triangles.push_back({i, j + 4, i + 4});
  }
  stage.add(walls, placed({offset, offset, 0.0}));
  stage.light(test::sun({0.3, 0.2, -1.0}, 10.0f));
  Camera inside = from_above(0.999);
  inside.camera_to_world[3] = {offset, offset, 0.5, 1.0};
  const Frame frame = stage.picture(inside, sized(200, 200));
  for (const float value : frame.passes.at("combined").pixels)
    EXPECT_TRUE(value == 0.0f || value == 1.0f) << value;  // colour, alpha
}

TEST(Shadows, ALightExactlyOnASurfaceLightsNoneOfIt) {
  Stage stage;
  stage.add(square(5.0f));
  stage.add(square(0.5f, 1.0f), placed({2.0, 0.0, 0.0}));
  stage.light(point_light({0.0, 0.0, 0.0}, 100.0f));
  const Frame frame =
      stage.picture(test::perspective({0.0, -6.0, 4.0}, {0.0, 0.0, 0.0}, 0.8), sized(64, 64));
  EXPECT_TRUE(test::all_finite(frame.passes.at("combined")));
  for (std::uint32_t y = 0; y < 64; ++y)
    for (std::uint32_t x = 0; x < 64; ++x) EXPECT_EQ(red(frame, x, y), 0.0f) << x << ' ' << y;
  const Frame below =
      stage.picture(test::perspective({2.0, -1.0, 0.2}, {2.0, 0.0, 1.0}, 0.3), sized(32, 32));
  EXPECT_GT(red(below, 16, 16), 0.1f);
}

TEST(Shadows, ALightInASphereThatTouchesItIsFiniteAndStaysInside) {
  Stage stage;
  stage.add(ball(64));
  stage.add(square(5.0f, -1.0f));
  stage.light(point_light({0.0, 0.0, -1.0}, 100.0f));
  const Frame outside =
      stage.picture(test::perspective({0.0, -6.0, 4.0}, {0.0, 0.0, -1.0}, 0.5), sized(64, 64));
  const Frame inside =
      stage.picture(test::perspective({0.0, -0.9, 0.0}, {0.0, 0.0, 0.3}, 0.8), sized(64, 64));
  EXPECT_TRUE(test::all_finite(outside.passes.at("combined")));
  EXPECT_TRUE(test::all_finite(inside.passes.at("combined")));
  EXPECT_GT(red(inside, 32, 32), 0.1f);
  for (std::uint32_t x = 0; x < 64; ++x) EXPECT_EQ(red(outside, x, 40), 0.0f);
}

TEST(Shadows, TheBackOfASurfaceIsLitFromTheBack) {
  Stage stage;
  stage.add(square(1.0f));
  stage.light(test::sun({0.0, 0.0, 1.0}, pi));
  EXPECT_EQ(red(stage.picture(from_above(0.5), sized(5, 5)), 2, 2), 0.0f);
  const Camera below = test::perspective({0.0, 0.0, -5.0}, {0.0, 0.0, 0.0}, 0.05);
  EXPECT_NEAR(red(stage.picture(below, sized(5, 5)), 2, 2), 1.0f, 1e-5f);
}

}  // namespace
}  // namespace regraft::render
