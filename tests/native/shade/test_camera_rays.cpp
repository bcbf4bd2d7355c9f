#include "regraft/shade/camera_rays.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <memory>
#include <numbers>

#include <glm/geometric.hpp>

namespace regraft::shade {
namespace {

using std::numbers::pi;
const Vec3d nothing_lo(1.0), nothing_hi(-1.0);
const Raster raster{48, 32, 0, 0, 48, 32};

/// A camera turned and moved every way, with an uneven scale that must not matter.
Camera tilted(CameraKind kind) {
  Camera camera;
  camera.kind = kind;
  const Vec3d back = glm::normalize(Vec3d(0.3, -0.8, 0.5));
  const Vec3d right = glm::normalize(glm::cross(Vec3d(0.1, 0.2, 1.0), back));
  camera.camera_to_world[0] = {2.0 * right, 0.0};
  camera.camera_to_world[1] = {0.5 * glm::cross(back, right), 0.0};
  camera.camera_to_world[2] = {3.0 * back, 0.0};
  camera.camera_to_world[3] = {10.0, -4.0, 2.5, 1.0};
  return camera;
}

/// A direction given in the camera's own frame.
Vec3d to_world(const Camera& camera, const Vec3d& local) {
  Vec3d world(0.0);
  for (int k = 0; k < 3; ++k) world += local[k] * glm::normalize(Vec3d(camera.camera_to_world[k]));
  return world;
}

/// The rays of the tile that holds pixel (x, y), and that pixel's lane.
struct Shot {
  std::unique_ptr<trace::RayPacket> rays = std::make_unique<trace::RayPacket>();
  std::uint32_t lane = 0;

  Shot(const CameraRays& camera, std::uint32_t x, std::uint32_t y, float u = 0.5f, float v = 0.5f) {
    PointLanes offsets;
    offsets.u.fill(u);
    offsets.v.fill(v);
    camera.generate(make_tile(raster, x / 8 * 8, y / 8 * 8), offsets, *rays);
    lane = y % 8 * 8 + x % 8;
  }
  Vec3d origin() const {
    return {rays->origin[0][lane], rays->origin[1][lane], rays->origin[2][lane]};
  }
  Vec3d direction() const {
    return {rays->direction[0][lane], rays->direction[1][lane], rays->direction[2][lane]};
  }
  bool active() const { return has_lane(rays->active, lane); }
};

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance = 1e-12) {
  EXPECT_LE(glm::length(a - b), tolerance);
}

TEST(CameraRays, PerspectiveRaysPassThroughTheirPointOnTheWindow) {
  Camera camera = tilted(CameraKind::perspective);
  camera.window = {-0.3, 0.9, -0.5, 0.2};
  const CameraRays rays(camera, raster, nothing_lo, nothing_hi);
  for (const auto& [x, y] : {std::pair{0u, 0u}, {47u, 31u}, {13u, 22u}}) {
    const Shot shot(rays, x, y, 0.25f, 0.75f);
    const Vec3d on_window(-0.3 + 1.2 * (x + 0.25) / 48, -0.5 + 0.7 * (y + 0.75) / 32, -1.0);
    expect_near(shot.direction(), to_world(camera, on_window));
    expect_near(shot.origin(), Vec3d(camera.camera_to_world[3]));
    EXPECT_TRUE(shot.active());
  }
}

TEST(CameraRays, OrthographicRaysAreParallelAndStartAtTheWindow) {
  Camera camera = tilted(CameraKind::orthographic);
  camera.window = {-2.0, 4.0, -1.0, 3.0};
  camera.clip_near = 0.5;
  const CameraRays rays(camera, raster, nothing_lo, nothing_hi);
  const Shot shot(rays, 40, 3);
  const Vec3d at(-2.0 + 6.0 * 40.5 / 48, -1.0 + 4.0 * 3.5 / 32, -0.5);
  expect_near(shot.direction(), to_world(camera, {0.0, 0.0, -1.0}));
  expect_near(shot.origin(), Vec3d(camera.camera_to_world[3]) + to_world(camera, at));
  EXPECT_FLOAT_EQ(rays.distance(*shot.rays, shot.lane, 2.0f), 2.5f);
}

TEST(CameraRays, EquirectangularDirectionsAreLongitudeAndLatitude) {
  Camera camera = tilted(CameraKind::equirectangular);
  camera.longitude = {-1.0, 2.5};
  camera.latitude = {-0.7, 1.2};
  const CameraRays rays(camera, raster, nothing_lo, nothing_hi);
  const Shot shot(rays, 30, 20);
  const double east = -1.0 + 3.5 * 30.5 / 48, north = -0.7 + 1.9 * 20.5 / 32;
  const Vec3d local(std::cos(north) * std::sin(east), std::sin(north),
                    -std::cos(north) * std::cos(east));
  expect_near(shot.direction(), to_world(camera, local));
}

TEST(CameraRays, TheMiddleOfAPanoramaLooksAhead) {
  const Camera camera = tilted(CameraKind::equirectangular);
  const CameraRays rays(camera, raster, nothing_lo, nothing_hi);
  expect_near(Shot(rays, 24, 16, 0.0f, 0.0f).direction(), to_world(camera, {0.0, 0.0, -1.0}));
}

/// Angle to the axis and direction round it, for a film point of a fisheye.
void expect_fisheye(CameraKind kind, double fov, double (*angle_of)(double, double)) {
  Camera camera = tilted(kind);
  camera.fov = fov;
  camera.window = {-1.2, 1.2, -0.8, 0.8};
  const CameraRays rays(camera, raster, nothing_lo, nothing_hi);
  const Vec3d ahead = to_world(camera, {0.0, 0.0, -1.0});
  for (std::uint32_t y = 0; y < 32; ++y)
    for (std::uint32_t x = 0; x < 48; ++x) {
      const double u = -1.2 + 2.4 * (x + 0.5) / 48, v = -0.8 + 1.6 * (y + 0.5) / 32;
      const double r = std::hypot(u, v);
      const Shot shot(rays, x, y);
      EXPECT_EQ(shot.active(), r <= 1.0);
      if (!shot.active()) continue;
      EXPECT_NEAR(std::acos(glm::dot(shot.direction(), ahead)), angle_of(r, fov), 1e-7);
      EXPECT_NEAR(glm::dot(shot.direction(), to_world(camera, {1.0, 0.0, 0.0})) * v,
                  glm::dot(shot.direction(), to_world(camera, {0.0, 1.0, 0.0})) * u, 1e-12);
      EXPECT_GT(glm::dot(shot.direction(), to_world(camera, {u, v, 0.0})), 0.0);
    }
}

TEST(CameraRays, AnEquidistantFisheyesAngleGrowsWithTheRadius) {
  expect_fisheye(CameraKind::fisheye_equidistant, 3.5,
                 [](double r, double fov) { return r * fov / 2; });
}

TEST(CameraRays, AnEquisolidFisheyeKeepsAreasInProportion) {
  // Solid angle of a cap, 2π (1 − cos θ), is proportional to r².
  expect_fisheye(CameraKind::fisheye_equisolid, pi, [](double r, double fov) {
    return std::acos(1.0 - r * r * (1.0 - std::cos(fov / 2)));
  });
}

TEST(CameraRays, PlanarClippingIsTheSameRangeForAllRaysOfAPerspective) {
  Camera camera = tilted(CameraKind::perspective);
  camera.clip_near = 0.25;
  camera.clip_far = 40.0;
  const CameraRays rays(camera, raster, nothing_lo, nothing_hi);
  const Shot shot(rays, 0, 0);
  EXPECT_EQ(shot.rays->t_near[shot.lane], 0.25f);
  EXPECT_EQ(shot.rays->t_far[shot.lane], 40.0f);
  const Vec3d back = glm::normalize(Vec3d(camera.camera_to_world[2]));
  EXPECT_NEAR(glm::dot(shot.direction(), -back), 1.0, 1e-12);
  EXPECT_NEAR(rays.distance(*shot.rays, shot.lane, 2.0f), 2.0 * glm::length(shot.direction()),
              1e-6);
}

TEST(CameraRays, PanoramicClippingIsRadial) {
  Camera camera = tilted(CameraKind::equirectangular);
  camera.clip_near = 0.5;
  const Shot shot(CameraRays(camera, raster, nothing_lo, nothing_hi), 3, 3);
  EXPECT_NEAR(glm::length(shot.direction()), 1.0, 1e-12);
  EXPECT_EQ(shot.rays->t_near[shot.lane], 0.5f);
}

TEST(CameraRays, AParallelProjectionSeesBehindItsPlaneAndStartsAtTheScene) {
  Camera camera = tilted(CameraKind::orthographic);
  camera.clip_near = -1e9;
  camera.clip_far = 1e9;
  const Vec3d middle = Vec3d(camera.camera_to_world[3]) + to_world(camera, {0.0, 0.0, 50.0});
  const CameraRays rays(camera, raster, middle - 1.0, middle + 1.0);
  const Shot shot(rays, 20, 20);
  EXPECT_LT(glm::length(shot.origin() - middle), 4.0);
  const double behind = glm::dot(shot.origin() - Vec3d(camera.camera_to_world[3]),
                                 to_world(camera, {0.0, 0.0, -1.0}));
  EXPECT_LT(behind, -50.0);
  EXPECT_NEAR(rays.distance(*shot.rays, shot.lane, 0.0f), behind, 1e-4);
}

TEST(CameraRays, AnUnboundedNearPlaneOfAnEmptySceneStaysFinite) {
  Camera camera = tilted(CameraKind::orthographic);
  camera.clip_near = -std::numeric_limits<double>::infinity();
  const Shot shot(CameraRays(camera, raster, nothing_lo, nothing_hi), 0, 0);
  EXPECT_TRUE(std::isfinite(glm::length(shot.origin())));
}

RC_GTEST_PROP(CameraRays, TilesHoldExactlyTheRegionsPixels, ()) {
  const auto side = [](std::uint32_t lo, std::uint32_t hi) { return *rc::gen::inRange(lo, hi); };
  Raster r{100, 90, side(0, 99), side(0, 89), 0, 0};
  r.x1 = side(r.x0 + 1, 101);
  r.y1 = side(r.y0 + 1, 91);
  const std::uint32_t x0 = side(0, 13) * 8, y0 = side(0, 12) * 8;
  const Tile tile = make_tile(r, x0, y0);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const std::uint32_t x = x0 + i % 8, y = y0 + i / 8;
    const bool inside = x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
    RC_ASSERT(has_lane(tile.active, i) == inside);
  }
}

}  // namespace
}  // namespace regraft::shade
