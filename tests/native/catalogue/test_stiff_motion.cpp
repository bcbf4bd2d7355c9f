#include <gtest/gtest.h>

#include "accel/tended.h"
#include "catalogue/motions.h"

// Catalogue G: motion far faster than a frame, under every policy.

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

constexpr std::size_t shard_count = 200;

std::string problems_of_shards(Motion motion, int frames = 4) {
  return problems_in_motion([&](const Moment& now) { return shards(shard_count, motion, now); },
                            frames);
}

Vec3d explosion(std::size_t i, const Moment& now) {
  return in_a_grid(i) + anywhere(i, 1, 3.0) * now.time;
}

TEST(StiffMotion, AnExplosionIsFollowed) {
  EXPECT_EQ(problems_of_shards(explosion), "");
}

TEST(StiffMotion, InAnExplosionSelectiveKeepsATreeThatRefitLosesFiveTimesOver) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended mended, refitted;
    const std::uint32_t mesh = add(mended.scene, shards(1000, explosion, {}));
    add(refitted.scene, shards(1000, explosion, {}));
    for (int frame = 0; frame < 20; ++frame) {
      const auto next = shards(1000, explosion, {frame, 1.0 * frame}).vertices;
      for (Tended* t : {&mended, &refitted}) t->scene.set_vertices(mesh, next);
      mended.accelerator.note_rays(100'000'000);
      mended.update(Policy::selective, layout);
      refitted.update(Policy::refit, layout);
    }
    EXPECT_LE(mended.accelerator.quality(mended.scene, true, pool(2)).cost_ratio, 1.1);
    EXPECT_GT(refitted.accelerator.quality(refitted.scene, true, pool(2)).cost_ratio, 5.0);
  }
}

TEST(StiffMotion, TwoObjectsMaySwapInOneFrame) {
  EXPECT_EQ(problems_of_shards([](std::size_t i, const Moment& now) {
              return in_a_grid(i < 2 && now.odd() ? (1 - i) * (shard_count - 1) : i);
            }),
            "");
}

TEST(StiffMotion, AThousandObjectsMayChangePlacesInEveryFrame) {
  Bed bed(policies());
  const std::uint32_t mesh =
      add_mesh(bed.scene, triangle({0, 0, 0}, {0.4f, 0, 0.1f}, {0.1f, 0.4f, 0}));
  std::vector<std::uint32_t> ids(1000);
  std::vector<Mat4d> places(1000);
  for (std::uint32_t& id : ids) id = add_instance(bed.scene, mesh);
  for (std::size_t frame = 0; frame < 3; ++frame) {
    for (std::size_t i = 0; i < ids.size(); ++i)
      places[i] = glm::translate(Mat4d(1.0), in_a_grid((i + 377 * frame) % ids.size()));
    bed.scene.set_transforms(ids, places);
    bed.note_rays(1'000'000);
    ASSERT_EQ(bed.update(), "") << frame;
    EXPECT_EQ(bed.differences(nasty_rays(SceneOracle(bed.scene), frame, 12)), "") << frame;
  }
}

TEST(StiffMotion, AClothMayFoldOntoItself) {
  const Geometry cloth = floor_grid(10, 1.0f);
  const auto folded = [&](const Moment& now) {
    // The right half turns over the left one, until both are one plane.
    const double angle = std::fmin(now.time, 3.0) * glm::pi<double>() / 3.0;
    return cloth.mapped([&](const Vec3d& v) {
      return v.x <= 0.0 ? v : Vec3d(v.x * std::cos(angle), v.y, v.x * std::sin(angle));
    });
  };
  EXPECT_EQ(problems_in_motion(folded), "");
}

TEST(StiffMotion, OneMayBeTeleportedAMillionUnitsAndBack) {
  EXPECT_EQ(problems_of_shards([](std::size_t i, const Moment& now) {
              return in_a_grid(i) + Vec3d(i == 7 && now.odd() ? 1e6 * now.time : 0.0);
            }),
            "");
}

TEST(StiffMotion, AllMayCollapseToAPointAndExpandAgain) {
  const Geometry whole = sphere(8, 12);
  for (const double size : {1e-12, 1e-30, 0.0}) {
    const auto pose = [&](const Moment& now) { return now.odd() ? whole.scaled(size) : whole; };
    EXPECT_EQ(problems_in_motion(pose), "") << size;
  }
}

TEST(StiffMotion, AMeshOfWhichNothingIsLeftComesBackWhole) {
  const Geometry whole = sphere(6, 8);
  for (const float gone : {nan, inf, 3.0f}) {
    const auto pose = [&](const Moment& now) {
      return whole.mapped([&](const Vec3d& v) { return now.odd() ? Vec3d(gone) : v; });
    };
    EXPECT_EQ(problems_in_motion(pose), "") << gone;
  }
}

TEST(StiffMotion, ATwistMayGiveEveryTriangleOtherNeighbours) {
  EXPECT_EQ(problems_of_shards([](std::size_t i, const Moment& now) {
              const Vec3d p = in_a_grid(i) - Vec3d(3.5, 3.5, 0);
              const double c = std::cos(now.time * p.z), s = std::sin(now.time * p.z);
              return Vec3d(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
            }),
            "");
}

TEST(StiffMotion, EveryTriangleMayBeAnywhereInEveryFrame) {
  EXPECT_EQ(problems_of_shards([](std::size_t i, const Moment& now) {
              return anywhere(i, 3 + std::uint64_t(now.time), 5.0);
            }),
            "");
}

TEST(StiffMotion, ALongBarMayTurnByHalfATurnAFrame) {
  const Geometry bar = box({-100, -0.5f, -0.5f}, {100, 0.5f, 0.5f});
  for (const double turn : {1.0, 0.37}) {
    const auto pose = [&](const Moment& now) {
      const double c = std::cos(turn * now.time * glm::pi<double>());
      const double s = std::sin(turn * now.time * glm::pi<double>());
      return bar.mapped(
          [&](const Vec3d& v) { return Vec3d(c * v.x - s * v.y, s * v.x + c * v.y, v.z); });
    };
    EXPECT_EQ(problems_in_motion(pose), "") << turn;
  }
}

TEST(StiffMotion, DoublingInEachOfAHundredFramesIsFollowed) {
  Bed bed(policies());
  const Geometry g = soup(24, 1, 1.0, 0.5);
  const std::uint32_t mesh = bed.add(g);
  for (int frame = 0; frame <= 100; ++frame) {
    bed.deform(mesh, g.scaled(std::exp2(frame)));
    bed.note_rays(1'000'000);
    ASSERT_EQ(bed.update(), "") << frame;
    if (frame % 20 != 0) continue;
    const std::vector<Ray> rays = nasty_rays(SceneOracle(bed.scene), std::uint64_t(frame), 24);
    ASSERT_EQ(bed.differences(rays), "") << frame;
    ASSERT_EQ(bed.complaints(rays), "") << frame;
  }
}

TEST(StiffMotion, AVertexMayShootFarAwayForAFrameAndLeaveNoTrace) {
  const Geometry whole = sphere(8, 12);
  const auto pose = [&](const Moment& now) {
    Geometry g = whole;
    if (now.odd()) g.vertices[5] = Vec3(1e20f);
    return g;
  };
  EXPECT_EQ(problems_in_motion(pose), "");
  Tended t;
  const std::uint32_t mesh = add(t.scene, whole);
  t.update(Policy::automatic);
  const double before = t.accelerator.quality(t.scene, false, pool(2)).sah_cost;
  for (const int frame : {1, 2}) {
    t.scene.set_vertices(mesh, pose({frame, 0.0}).vertices);
    t.accelerator.note_rays(1'000'000);
    t.update(Policy::automatic);
  }
  EXPECT_LT(t.accelerator.quality(t.scene, false, pool(2)).sah_cost, 1.2 * before);
}

TEST(StiffMotion, BetweenTwoPosesByTurnsWorkStaysWithinThatOfRebuilding) {
  constexpr std::size_t count = 1000;
  for (const Layout layout : {Layout::two_level, Layout::flat})
    for (const Policy policy : {Policy::selective, Policy::automatic}) {
      Tended t;
      const Motion motion = [](std::size_t i, const Moment& now) {
        return now.odd() ? anywhere(i, 2, 8.0) : in_a_grid(i);
      };
      const std::uint32_t mesh = add(t.scene, shards(count, motion, {}));
      for (int frame = 0; frame < 24; ++frame) {
        t.scene.set_vertices(mesh, shards(count, motion, {frame, 0.0}).vertices);
        t.accelerator.note_rays(100'000'000);
        const accel::UpdateStatistics s = t.update(policy, layout);
        EXPECT_LE(s.nodes_rebuilt, 3 * s.nodes) << frame;
        EXPECT_LE(s.pairs_considered, 4096u) << frame;
      }
      EXPECT_EQ(t.differences(1, 24), "");
    }
}

TEST(StiffMotion, AStaticSceneIsLeftAloneForThreeHundredFrames) {
  const Geometry ball = sphere(16, 24);
  for (const auto& setup : policies()) {
    Tended t;
    t.width = setup.structure == accel::Structure::kdtree ? 4 : 8;
    accel::UpdateOptions options;
    options.policy = setup.policy;
    options.layout = setup.layout;
    options.structure = setup.structure;
    const std::uint32_t mesh = add(t.scene, ball);
    t.update(options);
    for (int frame = 0; frame < 300; ++frame) {
      // The same positions: nothing that changed, hence nothing to do.
      t.scene.set_vertices(mesh, ball.vertices);
      t.accelerator.note_rays(1'000'000);
      const accel::UpdateStatistics s =
          t.accelerator.update(t.scene, t.scene.take_changes(), options, t.width, pool(2));
      ASSERT_EQ(s.nodes_refitted + s.nodes_rebuilt + s.pairs_considered + s.pairs_restructured, 0u)
          << setup;
    }
  }
}

TEST(StiffMotion, WhenOneOfAThousandObjectsMovesTheMeshesOfOthersAreLeftAlone) {
  Tended t;
  const Geometry ball = sphere(5, 7);
  for (std::size_t i = 0; i < 1000; ++i)
    add(t.scene, ball, glm::translate(Mat4d(1.0), 3.0 * in_a_grid(i)));
  t.update(Policy::automatic);
  t.scene.set_vertices(500, ball.scaled(1.1).vertices);
  accel::UpdateStatistics s = t.update(Policy::automatic);
  const std::uint64_t of_a_ball = 2 * ball.triangles.size(), of_the_top = 2 * 1000;
  EXPECT_EQ(s.deformed_meshes, 1u);
  EXPECT_LE(s.nodes_refitted + s.nodes_rebuilt, of_a_ball + 2 * of_the_top);
  t.scene.set_transform(500, glm::translate(Mat4d(1.0), Vec3d(1, 2, 3)));
  s = t.update(Policy::automatic);
  EXPECT_EQ(s.moved_instances, 1u);
  EXPECT_EQ(s.deformed_meshes, 0u);
  EXPECT_LE(s.nodes_refitted + s.nodes_rebuilt, 2 * of_the_top) << "refitted, then rebuilt";
  EXPECT_EQ(t.differences(1, 24), "");
}

/// Traces rays down the column at `x` and tells the trees.
void look_at(Tended& t, double x) {
  std::vector<Ray> rays;
  Random random(3);
  for (int i = 0; i < 64; ++i) rays.push_back({Vec3d(x, 3.5, 20) + random.in_box(1.0), {0, 0, -1}});
  closest_hits({t.accelerator.view(), simd::Isa::scalar}, rays, Entry::single);
  t.accelerator.note_rays(64, 640, 64);
}

TEST(StiffMotion, AfterACutOnlyWhatTheNewViewEntersCounts) {
  Tended cut, steady;
  const auto next = [](Tended& t, double time) {
    t.scene.set_vertices(0, shards(500, explosion, {1, time}).vertices);
    return t.update(Policy::selective).culling_efficiency;
  };
  for (Tended* t : {&cut, &steady}) {
    t->width = 4;
    add(t->scene, shards(500, explosion, {}));
    t->update(Policy::selective);
  }
  look_at(cut, 1.0);
  look_at(steady, 6.0);
  EXPECT_NE(next(cut, 0.01), next(steady, 0.01)) << "they look elsewhere";
  look_at(cut, 6.0);
  look_at(steady, 6.0);
  EXPECT_EQ(next(cut, 0.02), next(steady, 0.02));
}

}  // namespace
}  // namespace regraft::test
