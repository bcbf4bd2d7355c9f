#include "regraft/shade/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "render/stage.h"

namespace regraft::shade {
namespace {

using test::ball;
using test::placed;
using test::Shape;
using test::square;
using test::Stage;

/// What a fan of 64 rays from `eye` towards `target` sees.
struct Seen {
  std::unique_ptr<trace::RayPacket> rays = std::make_unique<trace::RayPacket>();
  std::unique_ptr<trace::HitPacket> hits = std::make_unique<trace::HitPacket>();
  std::unique_ptr<SurfaceLanes> surface = std::make_unique<SurfaceLanes>();
  std::unique_ptr<InstanceCache> cache;

  Seen(Stage& stage, const Vec3d& eye, const Vec3d& target, double half = 0.01) {
    stage.renderer.update({});
    stage.renderer.render(test::from_above(1.0), [] {
      render::RenderSettings settings = test::sized(1, 1);
      settings.passes = {"normal"};  // brings the shading normals up to date
      return settings;
    }());
    const Mat4d frame = test::looking(eye, target);
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      const double x = half * ((i % 8) / 3.5 - 1.0), y = half * ((i / 8) / 3.5 - 1.0);
      const Vec3d d = Vec3d(frame[0]) * x + Vec3d(frame[1]) * y - Vec3d(frame[2]);
      for (int k = 0; k < 3; ++k) {
        rays->origin[k][i] = eye[k];
        rays->direction[k][i] = d[k];
      }
      rays->t_near[i] = 0.0f;
      rays->t_far[i] = std::numeric_limits<float>::infinity();
    }
    rays->count = lane_count;
    rays->active = all_lanes;
    trace::TraceCounters counters;
    stage.renderer.tracer().closest_hit(*rays, *hits, counters);
    cache = std::make_unique<InstanceCache>(stage.renderer.scene(), stage.renderer.accelerator());
    const LaneMask hit = hit_lanes(*hits, all_lanes);
    if (hit != 0) find_surfaces(*rays, *hits, hit, {true, true}, *cache, *surface);
  }
  bool hit(std::uint32_t i) const { return has_lane(surface->active, i); }
  Vec3d position(std::uint32_t i) const {
    return {surface->position[0][i], surface->position[1][i], surface->position[2][i]};
  }
  static Vec3d at(const Vec3Lanes& v, std::uint32_t i) { return {v.x[i], v.y[i], v.z[i]}; }
};

TEST(Surface, PositionsLieJustOffTheSurfaceOnTheViewersSide) {
  for (const Vec3d& where : {Vec3d(0.0), Vec3d(1e6, 0.0, 0.0), Vec3d(-1e9, 3e8, 0.0)})
    for (const double scale : {1e-6, 1.0, 1e9}) {
      Stage stage;
      stage.add(square(1.0f), placed(where, Vec3d(scale)));
      const Seen seen(stage, where + scale * Vec3d(0.3, 0.2, 5.0), where);
      const double error = std::fabs(where.x) * 1e-15;
      for (std::uint32_t i = 0; i < lane_count; ++i) {
        ASSERT_TRUE(seen.hit(i));
        const double height = seen.position(i).z - where.z;
        EXPECT_GT(height, 0.0);
        EXPECT_LT(height, 1e-4 * scale + 100 * error);
      }
    }
}

TEST(Surface, PositionsAreWhereTheRayMeetsTheTriangle) {
  Stage stage;
  stage.add(square(4.0f), placed({5.0, -3.0, 2.0}));
  const Vec3d eye(6.0, -1.0, 9.0);
  const Seen seen(stage, eye, {5.0, -3.0, 2.0}, 0.3);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const Vec3d d(seen.rays->direction[0][i], seen.rays->direction[1][i],
                  seen.rays->direction[2][i]);
    const Vec3d expected = eye + d * ((2.0 - eye.z) / d.z);
    EXPECT_LT(glm::length(seen.position(i) - expected), 1e-4);
  }
}

TEST(Surface, NormalsAreUnitAndPerpendicularUnderAnyScale) {
  // The plane x + z = 0 of object space, stretched: in the world x / a + z / c = 0.
  const Shape tilted{{{-1, -1, 1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, 1}}, {{0, 1, 2}, {0, 2, 3}}};
  for (const Vec3d& scale : {Vec3d(1.0), Vec3d(3.0, 1.0, 0.2), Vec3d(-2.0, 1.0, 1.0),
                             Vec3d(1e-4, 1.0, 1e4), Vec3d(1.0, 1.0, 0.0)}) {
    Stage stage;
    stage.add(tilted, placed(Vec3d(0.0), scale));
    const Vec3d expected = glm::normalize(Vec3d(scale.z, 0.0, scale.x));
    const double side = expected.z < 0.0 ? -1.0 : 1.0;
    const Vec3d eye = 10.0 * glm::length(scale) * (side * expected + Vec3d(0.0, 0.01, 0.0));
    const Seen seen(stage, eye, Vec3d(0.0), 1e-5);
    ASSERT_TRUE(seen.hit(27)) << scale.x << ' ' << scale.y << ' ' << scale.z;
    EXPECT_LT(glm::length(Seen::at(seen.surface->geometric, 27) - side * expected), 1e-5);
    EXPECT_LT(glm::length(Seen::at(seen.surface->normal, 27) - side * expected), 1e-5);
  }
}

TEST(Surface, SmoothNormalsOfASphereAreRadial) {
  Stage stage;
  stage.add(ball(64, 2.0f, true), placed({1.0, 2.0, 3.0}));
  const Seen seen(stage, {1.0, -8.0, 4.0}, {1.0, 2.0, 3.0}, 0.15);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const Vec3d radial = glm::normalize(seen.position(i) - Vec3d(1.0, 2.0, 3.0));
    EXPECT_GT(glm::dot(radial, Seen::at(seen.surface->normal, i)), 0.9999);
  }
}

TEST(Surface, SmoothSurfacesAreLiftedTowardsTheCurveTheyStandFor) {
  // A coarse sphere: tangent planes at its corners lie outside it, facets inside.
  for (const Vec3d& scale : {Vec3d(1.0), Vec3d(-1.0, 1.0, 1.0), Vec3d(1.0, 1.0, 0.25)}) {
    Stage stage;
    stage.add(ball(6, 1.0f, true), placed(Vec3d(0.0), scale));
    const Seen seen(stage, {3.0, -4.0, 1.0}, Vec3d(0.0), 0.04);
    double lowest = 2.0;
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      ASSERT_TRUE(seen.hit(i));
      const double radius = glm::length(seen.position(i) / scale);
      lowest = std::min(lowest, radius);
      EXPECT_LT(radius, 1.07);
    }
    EXPECT_GT(lowest, 0.985);  // facets go down to 0.94
  }
}

TEST(Surface, FromInsideASmoothBodyNothingIsLifted) {
  Stage stage;
  stage.add(ball(6, 1.0f, true));
  const Seen seen(stage, {0.01, 0.02, 0.0}, {0.3, 1.0, 0.2}, 0.3);
  for (std::uint32_t i = 0; i < lane_count; ++i) EXPECT_LT(glm::length(seen.position(i)), 1.0);
}

TEST(Surface, FlatCornersUseTheTriangle) {
  Stage stage;
  Shape shape = square(1.0f);
  MeshData data;
  data.vertices = shape.vertices;
  data.triangles = shape.triangles;
  const std::vector<glm::uvec3> ids{{0, flat_corner, flat_corner},
                                    {flat_corner, flat_corner, flat_corner}};
  data.normal_ids = ids;
  Instance instance;
  instance.mesh = stage.renderer.scene().add_mesh(data, "");
  stage.renderer.scene().add_instance(instance);
  const Seen seen(stage, {0.1, 0.1, 4.0}, Vec3d(0.0), 0.2);
  for (std::uint32_t i = 0; i < lane_count; ++i)
    EXPECT_NEAR(seen.surface->normal.z[i], 1.0f, 1e-6f);
}

TEST(Surface, LanesWithoutAHitRepeatOneThatHas) {
  Stage stage;
  stage.add(square(0.5f));
  const Seen seen(stage, {0.0, 0.0, 4.0}, Vec3d(0.0), 0.4);
  ASSERT_TRUE(seen.surface->active != 0 && seen.surface->active != all_lanes);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    EXPECT_NEAR(glm::length(Seen::at(seen.surface->normal, i)), 1.0, 1e-6);
    EXPECT_TRUE(std::isfinite(seen.position(i).z));
  }
}

TEST(Surface, MaterialsAreThoseOfSlotAndInstance) {
  Stage stage;
  stage.renderer.scene().set_materials({test::plain({0.1f, 0, 0}), test::plain({0.2f, 0, 0})});
  stage.add(square(1.0f), placed({-1.0, 0.0, 0.0}), {1});
  stage.add(square(1.0f), placed({1.0, 0.0, 0.0}), {});
  const Seen seen(stage, {0.0, 0.0, 4.0}, Vec3d(0.0), 0.2);
  EXPECT_FALSE(seen.surface->one_material);
  EXPECT_EQ(seen.surface->material[0]->base_color.x, 0.2f);
  EXPECT_EQ(seen.surface->material[7]->base_color, Material{}.base_color);
}

TEST(Surface, TinyAndHugeTrianglesHaveNormals) {
  for (const float size : {1e-30f, 1e-18f, 1e15f, 1e30f}) {
    Stage stage;
    stage.add(square(size));
    const Seen seen(stage, Vec3d(0.1, 0.1, 4.0) * double(size), Vec3d(0.0));
    if (!seen.hit(0)) continue;  // whether so small a triangle can be hit is the tracer's business
    EXPECT_NEAR(seen.surface->geometric.z[0], 1.0f, 1e-6f) << size;
  }
}

}  // namespace
}  // namespace regraft::shade
