#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>
#include <thread>

#include "accel/tended.h"
#include "regraft/trace/closest_point.h"
#include "regraft/trace/kernels.h"

// Deforming meshes that rays keep away from: only bounded, until a ray comes near.

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;
using accel::UpdateStatistics;

constexpr Policy every_policy[] = {
    Policy::automatic, Policy::refit,     Policy::rebuild,          Policy::lm,
    Policy::rtdeform,  Policy::selective, Policy::selective_rotate, Policy::shot};

Mat4d at(double x, double y, double z) {
  return glm::translate(Mat4d(1.0), Vec3d(x, y, z));
}

bool is_left_behind(const UpdateStatistics& s) {
  return std::ranges::any_of(s.left_out, [](const std::string& sentence) {
    return sentence.starts_with("1 deformed meshes far from all rays of late: only bounded");
  });
}

std::vector<Ray> rays_to(const Vec3d& target) {
  std::vector<Ray> rays;
  Random random(7);
  for (int i = 0; i < 64; ++i) {
    const Vec3d from = target + Vec3d(0.0, 0.0, 5.0);
    rays.push_back({from, target + random.in_box(0.5) - from});
  }
  return rays;
}

/// A sphere that is looked at, and meshes far away that nobody looks at for now.
class Stage : public Tended {
 public:
  explicit Stage(Geometry hidden = torus(24, 16, 0.4)) : shape(std::move(hidden)) {
    add(scene, sphere(12, 16));
    far = add(scene, shape, at(100, 0, 0));
  }

  /// One frame: the mesh far away is bent, the sphere looked at.
  UpdateStatistics frame() {
    bend();
    const UpdateStatistics statistics = update(policy);
    look(Vec3d(0.0));
    return statistics;
  }
  /// Until the mesh far away is left behind, which takes ever longer. Nobody looks at that frame.
  void leave() {
    for (int i = 0; i < 40; ++i) {
      bend();
      if (is_left_behind(update(policy))) return;
      look(Vec3d(0.0));
    }
    ADD_FAILURE() << "never left behind";
  }
  void bend() {
    ++bends;
    scene.set_vertices(far, shape
                                .mapped([&](const Vec3d& p) {
                                  return Vec3d(p.x + 0.1 * std::sin(3.0 * p.z + bends),
                                               1.0 + 0.1 * (bends % 4), 1.0) *
                                         p;
                                })
                                .vertices);
  }
  void look(const Vec3d& target) {
    closest_hits(tracer(), rays_to(target), Entry::packet);
    accelerator.note_rays(64);
  }
  trace::Tracer tracer() const {
    for (const simd::Isa isa : simd::available_isas())
      if (trace::kernels(isa).width == width) return {accelerator.view(), isa};
    throw std::logic_error("no kernels of that width");
  }
  std::uint64_t late_updates() {
    UpdateStatistics statistics;
    accelerator.count_late(statistics);
    return statistics.late_updates;
  }

  Geometry shape;
  std::uint32_t far;
  Policy policy = Policy::refit;
  int bends = 0;
};

TEST(LateMeshes, ADeformingMeshThatRaysKeepAwayFromIsOnlyBounded) {
  Stage stage;
  EXPECT_GT(stage.frame().nodes_rebuilt, 100u);
  EXPECT_GT(stage.frame().nodes_refitted, 100u);
  stage.leave();
  stage.bend();
  const UpdateStatistics s = stage.update(Policy::refit);
  EXPECT_EQ(s.late_updates, 0u);
  EXPECT_EQ(s.deformed_meshes, 1u);
  EXPECT_EQ(s.nodes_refitted, 3u) << "the top tree's";
  EXPECT_TRUE(is_left_behind(s));
  Stage eager;
  while (eager.bends < stage.bends) eager.bend();
  eager.update();
  EXPECT_EQ(stage.accelerator.world_bounds(), eager.accelerator.world_bounds());
}

TEST(LateMeshes, TheFirstRaysThatComeNearFindItUpToDateUnderEveryPolicy) {
  for (const Policy policy : every_policy)
    for (const int width : {4, 8}) {
      Stage stage;
      stage.policy = policy;
      stage.width = width;
      stage.leave();
      EXPECT_EQ(stage.differences(), "");
      EXPECT_EQ(stage.late_updates(), 1u);
      EXPECT_EQ(stage.late_updates(), 0u) << "told once";
      EXPECT_EQ(stage.accelerator.validate(stage.scene), "");
      stage.frame();
      EXPECT_EQ(stage.differences(), "");
    }
}

TEST(LateMeshes, ManyFramesThatNobodySawAreOneUpdate) {
  Stage stage;
  stage.leave();
  Random random(3);
  std::vector<Vec3> vertices = stage.scene.meshes()[stage.far].vertices;
  for (int i = 0; i < 30; ++i) {
    vertices[random.below(vertices.size())] += Vec3(random.in_box(0.3));
    stage.scene.set_vertices(stage.far, vertices);
    stage.update(Policy::refit);
    stage.look(Vec3d(0.0));
  }
  EXPECT_EQ(stage.late_updates(), 0u);
  EXPECT_EQ(stage.differences(), "");
  EXPECT_EQ(stage.late_updates(), 1u);
}

TEST(LateMeshes, OneThatRestsWaitsWithoutBeingBoundedAgain) {
  Stage stage;
  stage.leave();
  for (int i = 0; i < 3; ++i) {
    stage.scene.set_transform(0, at(0, 0.1 * i, 0));
    const UpdateStatistics s = stage.update(Policy::refit);
    EXPECT_EQ(s.deformed_meshes, 0u);
    stage.look(Vec3d(0.0));
  }
  EXPECT_EQ(stage.late_updates(), 0u);
  EXPECT_EQ(stage.differences(), "");
  EXPECT_EQ(stage.late_updates(), 1u);
}

TEST(LateMeshes, ManyThreadsMayComeNearAtOnce) {
  for (const Policy policy : {Policy::refit, Policy::rebuild}) {
    Stage stage;
    stage.policy = policy;
    add_instance(stage.scene, stage.far, at(100, 3, 0));
    stage.leave();
    std::vector<Ray> rays = rays_to(Vec3d(100, 0, 0));
    for (const Ray& ray : rays_to(Vec3d(100, 3, 0))) rays.push_back(ray);
    const std::vector<Found> wanted = hits_anew(stage.scene, rays);
    std::vector<std::thread> threads;
    for (int i = 0; i < 6; ++i)
      threads.emplace_back(
          [&, i] { EXPECT_EQ(closest_hits(stage.tracer(), rays, entries[i % 2]), wanted); });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(stage.late_updates(), 1u);
  }
}

TEST(LateMeshes, NearestPointsAreLookedForInTheTreeAsItIsNow) {
  Stage stage, other;
  stage.leave();
  while (other.bends < stage.bends) other.bend();
  other.update();
  const Vec3d p(98.0, 0.3, 0.1);
  const trace::PointHit wanted = trace::closest_point(other.accelerator.view(), p, 1e9);
  const trace::PointHit found = trace::closest_point(stage.accelerator.view(), p, 1e9);
  EXPECT_EQ(found.distance, wanted.distance);
  EXPECT_EQ(found.prim_id, wanted.prim_id);
  EXPECT_EQ(stage.late_updates(), 1u);
}

TEST(LateMeshes, QualityIsThatOfTreesThatHaveCaughtUp) {
  Stage stage, eager;
  stage.leave();
  while (eager.bends < stage.bends) {
    eager.bend();
    eager.update(Policy::refit);
  }
  const accel::Quality late = stage.accelerator.quality(stage.scene, true, pool(2));
  const accel::Quality wanted = eager.accelerator.quality(eager.scene, true, pool(2));
  EXPECT_EQ(late.sah_cost, wanted.sah_cost);
  EXPECT_EQ(late.epo, wanted.epo);
  EXPECT_EQ(late.cost_ratio, wanted.cost_ratio);
  EXPECT_EQ(stage.late_updates(), 1u);
}

/// Triangles that cannot be hit, and a vertex that none uses, stick out of the sphere.
Geometry ragged() {
  Geometry g = sphere(8, 12);
  const auto first = std::uint32_t(g.vertices.size());
  g.vertices.insert(g.vertices.end(), {{3, 0, 0}, {4, 0, 0}, {5, 0, 0}, {0, 9, 0}});
  g.triangles.push_back({first, first + 1, first + 2});
  return g;
}

TEST(LateMeshes, BoundsAreThoseOfTrianglesThatCanBeHit) {
  for (const bool has_nan : {false, true}) {
    Stage stage(ragged()), eager(ragged());
    if (has_nan) stage.shape.vertices[5].y = eager.shape.vertices[5].y = nan;
    stage.leave();
    while (eager.bends < stage.bends) {
      eager.bend();
      eager.update(Policy::refit);
    }
    EXPECT_EQ(stage.accelerator.world_bounds(), eager.accelerator.world_bounds());
    EXPECT_EQ(stage.differences(), "");
    EXPECT_EQ(stage.late_updates(), 1u);
  }
}

TEST(LateMeshes, ATriangleThatComesToLifeIsNotWaitedWith) {
  Stage stage(ragged());
  stage.leave();
  std::vector<Vec3> vertices = stage.scene.meshes()[stage.far].vertices;
  vertices[vertices.size() - 2].y += 1.0f;
  stage.scene.set_vertices(stage.far, vertices);
  EXPECT_GT(stage.update(Policy::refit).nodes_rebuilt, 50u);
  EXPECT_EQ(stage.differences(), "");
  EXPECT_EQ(stage.late_updates(), 0u);
}

TEST(LateMeshes, OneOfWhichNothingIsLeftIsNotWaitedWith) {
  for (const Policy policy : every_policy) {
    Stage stage;
    stage.policy = policy;
    stage.frame();
    stage.leave();
    const std::size_t count = stage.scene.meshes()[stage.far].vertices.size();
    stage.scene.set_vertices(stage.far, std::vector<Vec3>(count, Vec3(1.0f)));
    EXPECT_FALSE(is_left_behind(stage.update(policy)));
    EXPECT_EQ(stage.differences(), "");
    stage.bend();
    stage.update(policy);
    EXPECT_EQ(stage.differences(), "");
  }
}

TEST(LateMeshes, WhatIsBehindMayBeHiddenShownChangedBakedAndRemoved) {
  Stage stage;
  stage.leave();
  stage.scene.set_visible(1, false);
  stage.update(Policy::refit);
  EXPECT_EQ(stage.differences(), "");
  stage.scene.set_visible(1, true);
  stage.update(Policy::refit);
  EXPECT_EQ(stage.differences(), "");

  stage.leave();
  const std::uint32_t flat =
      add_instance(stage.scene, stage.far, glm::scale(at(100, 9, 0), Vec3d(1.0, 1.0, 0.0)));
  stage.bend();
  stage.update(Policy::refit);
  EXPECT_EQ(stage.differences(), "");

  stage.leave();
  stage.update(Policy::refit, Layout::flat);
  EXPECT_EQ(stage.differences(), "");
  stage.update(Policy::refit);

  stage.leave();
  stage.scene.set_mesh(stage.far, sphere(5, 7).data());
  stage.update(Policy::refit);
  EXPECT_EQ(stage.differences(), "");
  stage.shape = sphere(5, 7);

  stage.leave();
  add(stage.scene, box(Vec3(-1), Vec3(1)), at(-50, 0, 0));
  stage.update(Policy::refit);
  EXPECT_EQ(stage.differences(), "");

  stage.leave();
  stage.scene.remove_instance(1);
  stage.scene.remove_instance(flat);
  stage.scene.remove_mesh(stage.far);
  stage.update(Policy::refit);
  EXPECT_EQ(stage.differences(), "");
}

}  // namespace
}  // namespace regraft::test
