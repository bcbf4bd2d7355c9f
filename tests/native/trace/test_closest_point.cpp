#include "regraft/trace/closest_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "regraft/accel/accelerator.h"
#include "trace/compare.h"
#include "trace/scene_oracle.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Structure;
using trace::PointHit;

struct Kept {
  Layout layout;
  int width;
  Structure structure;
  accel::Accelerator trees;
};

/// A scene kept in every layout and width, asked for nearest points.
struct Points {
  Scene scene;
  Executor executor{2};
  Kept kept[5]{{Layout::two_level, 8, Structure::bvh, {}},
               {Layout::two_level, 4, Structure::bvh, {}},
               {Layout::flat, 8, Structure::bvh, {}},
               {Layout::flat, 4, Structure::bvh, {}},
               {Layout::two_level, 8, Structure::kdtree, {}}};

  void update() {
    const ChangeSet changes = scene.take_changes();
    for (Kept& k : kept) {
      accel::UpdateOptions options;
      options.layout = k.layout;
      options.structure = k.structure;
      options.policy = accel::Policy::refit;
      k.trees.update(scene, changes, options, k.width, executor);
    }
  }

  /// What is wrong with an answer, by every triangle in wider arithmetic and by the other layouts.
  void check(const Vec3d& p, double reach = std::numeric_limits<double>::infinity()) const {
    const PointHit want = trace::closest_point_brute_force(kept[0].trees.view(), p, reach);
    for (const Kept& k : kept) {
      const PointHit got = trace::closest_point(k.trees.view(), p, reach);
      EXPECT_EQ(got.distance, want.distance);
      EXPECT_EQ(got.instance_id, want.instance_id);
      EXPECT_EQ(got.prim_id, want.prim_id);
      EXPECT_EQ(got.point, want.point);
      EXPECT_EQ(got.u, want.u);
      EXPECT_EQ(got.v, want.v);
    }
    Real nearest = std::numeric_limits<Real>::infinity(), magnitude = glm::length(p);
    const SceneOracle oracle(scene);
    for (const WorldTriangle& t : oracle.triangles()) {
      nearest = std::min(nearest, distance({p.x, p.y, p.z}, t.corners));
      magnitude = std::max(magnitude, t.magnitude);
    }
    if (nearest > reach * (1.0L + 1e-12L)) {
      EXPECT_EQ(want.instance_id, invalid_id);
    } else if (nearest < reach * (1.0L - 1e-12L)) {
      EXPECT_NEAR(double(want.distance - nearest), 0.0, double(magnitude) * 1e-13);
    }
  }
};

TEST(ClosestPoint, IsTheNearestOfASoupBeforeAndAfterItMoves) {
  Points points;
  Random random(1);
  const std::uint32_t mesh = add_mesh(points.scene, soup(120, 1, 1.0, 0.3));
  add_instance(points.scene, mesh);
  for (int frame = 0; frame < 2; ++frame) {
    points.update();
    for (int i = 0; i < 60; ++i) points.check(random.in_box(2.0));
    points.scene.set_vertices(mesh, soup(120, 2, 1.5, 0.3).vertices);
  }
}

TEST(ClosestPoint, IsTheNearestOfInstancesShearedMirroredAndSquashed) {
  Points points;
  Random random(4);
  const std::uint32_t mesh = add_mesh(points.scene, soup(60, 4, 1.0, 0.3));
  for (int i = 0; i < 6; ++i) {
    Mat4d m = anyhow(random, 2.0);
    m[1] += random.uniform(-2.0, 2.0) * m[0];
    m[2] *= random.uniform(-2.0, 0.5);
    add_instance(points.scene, mesh, m);
  }
  points.update();
  for (int i = 0; i < 80; ++i) points.check(random.in_box(4.0));
}

TEST(ClosestPoint, IsRightFarFromTheOriginAndAtExtremeScales) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Points points;
    Random random(7);
    const Vec3d away(scale * 1e5, -scale * 1e5, 0.0);
    const std::uint32_t mesh = add_mesh(points.scene, sphere(8, 12).scaled(scale));
    add_instance(points.scene, mesh, glm::translate(Mat4d(1.0), away));
    points.update();
    for (int i = 0; i < 30; ++i) points.check(away + random.in_box(2.0 * scale));
  }
}

TEST(ClosestPoint, OfEquallyNearTrianglesIsTheLowest) {
  Points points;
  const std::uint32_t mesh = add_mesh(points.scene, floor_grid(4, 1.0f));
  add_instance(points.scene, mesh);
  add_instance(points.scene, mesh);
  points.update();
  for (const Kept& k : points.kept) {
    const PointHit hit = trace::closest_point(k.trees.view(), {0.0, 0.0, 1.0}, 5.0);
    EXPECT_EQ(hit.instance_id, 0u);
    EXPECT_EQ(hit.distance, 1.0);
  }
  points.check({0.0, 0.0, 1.0});
  points.check({3.0, 0.25, 0.0});
}

TEST(ClosestPoint, BeyondTheReachIsNothing) {
  Points points;
  add_instance(points.scene, add_mesh(points.scene, floor_grid(1, 1.0f)));
  points.update();
  for (const Kept& k : points.kept) {
    EXPECT_EQ(trace::closest_point(k.trees.view(), {0.0, 0.0, 2.0}, 2.0).distance, 2.0);
    EXPECT_EQ(trace::closest_point(k.trees.view(), {0.0, 0.0, 2.0}, 1.9).prim_id, invalid_id);
    EXPECT_EQ(trace::closest_point(k.trees.view(), {NAN, 0.0, 2.0}, 9.0).prim_id, invalid_id);
    EXPECT_EQ(trace::closest_point(k.trees.view(), {1e300, 0.0, 2.0}, 9.0).prim_id, invalid_id);
  }
}

TEST(ClosestPoint, OfAnEmptySceneIsNothing) {
  Points points;
  points.update();
  for (const Kept& k : points.kept)
    EXPECT_EQ(trace::closest_point(k.trees.view(), {0.0, 0.0, 0.0}, 1.0).instance_id, invalid_id);
}

}  // namespace
}  // namespace regraft::test
