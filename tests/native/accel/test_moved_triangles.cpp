#include "regraft/accel/moved_triangles.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "accel/tended.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::MovedTriangles;
using accel::Policy;

/// Moves `count` neighbouring vertices.
void shake(std::vector<Vec3>& vertices, std::size_t first, std::size_t count, Random& random) {
  for (std::size_t v = first; v < std::min(first + count, vertices.size()); ++v)
    vertices[v] += Vec3(random.in_box(0.4));
}

TEST(MovedTriangles, AreThoseOnBlocksThatMovedAndEachIsListedOnce) {
  Scene scene;
  Geometry g = sphere(40, 60);
  const std::uint32_t id = add(scene, g);
  MovedTriangles moved;
  moved.reset(scene.meshes()[id]);
  Random random(1);
  for (const std::size_t first : {0, 700, 1300, 2330}) {
    const std::vector<Vec3> before = g.vertices;
    shake(g.vertices, first, 50, random);
    scene.set_vertices(id, g.vertices);
    const accel::Motion motion = moved.take(scene.meshes()[id], pool(2));
    ASSERT_FALSE(motion.all);
    const std::set<std::uint32_t> listed(motion.prims.begin(), motion.prims.end());
    EXPECT_EQ(listed.size(), motion.prims.size());
    EXPECT_LT(listed.size(), g.triangles.size() / 8);
    for (std::uint32_t t = 0; t < g.triangles.size(); ++t) {
      bool has_moved = false;
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t v = g.triangles[t][k];
        has_moved |= before[v] != g.vertices[v];
      }
      if (has_moved) {
        EXPECT_TRUE(listed.contains(t)) << t;
      }
    }
  }
  EXPECT_TRUE(moved.take(scene.meshes()[id], pool(2)).prims.empty()) << "nothing since";
  scene.set_vertices(id, g.scaled(2.0).vertices);
  EXPECT_TRUE(moved.take(scene.meshes()[id], pool(2)).all);
}

/// A sphere of which now a few vertices move, now many, now none, now one is lost, and two
/// instances of it, one of which moves by itself.
void replay(Tended& t, Policy policy, Layout layout, std::uint64_t seed) {
  Geometry g = sphere(28, 44);
  const std::uint32_t mesh = add(t.scene, g);
  const std::uint32_t other =
      add_instance(t.scene, mesh, glm::translate(Mat4d(1.0), Vec3d(3, 0, 0)));
  Random random(seed);
  for (int f = 0; f < 11; ++f) {
    const std::size_t first = random.below(g.vertices.size());
    const Vec3 kept = g.vertices[first];
    if (f % 5 != 4) shake(g.vertices, first, f % 7 == 6 ? 600 : 30, random);
    if (f == 5) g.vertices[first].x = std::numeric_limits<float>::quiet_NaN();
    t.scene.set_vertices(mesh, g.vertices);
    if (f == 5) g.vertices[first] = kept;
    if (f % 4 == 3)
      t.scene.set_transform(other, glm::translate(Mat4d(1.0), Vec3d(3 + 0.1 * f, 0, 0)));
    t.accelerator.note_rays(100'000'000);
    t.update(policy, layout);
  }
}

TEST(MovedTriangles, EveryPolicyFindsTheSameHitsWhereOnlyAPartMoves) {
  for (const Policy policy : all_policies)
    for (const Layout layout : {Layout::two_level, Layout::flat}) {
      Tended t;
      replay(t, policy, layout, 5);
      EXPECT_EQ(t.differences(1, 24), "") << name(policy) << name(layout);
    }
}

TEST(MovedTriangles, OnlyWhatLiesAboveThemIsRefitted) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended t;
    Geometry g = sphere(40, 60);
    const std::uint32_t mesh = add(t.scene, g);
    const auto built = t.update(Policy::refit, layout);
    Random random(1);
    for (int f = 0; f < 4; ++f) {
      shake(g.vertices, 640, 64, random);
      t.scene.set_vertices(mesh, g.vertices);
      const auto s = t.update(Policy::refit, layout);
      if (f == 0) continue;  // links upwards are made when they are first needed
      EXPECT_GT(s.nodes_refitted, 20u);
      EXPECT_LT(s.nodes_refitted, built.nodes / 4);
    }
  }
}

TEST(MovedTriangles, TheTopTreeFollowsSingleInstances) {
  Tended t;
  const std::uint32_t mesh = add(t.scene, sphere(4, 6));
  for (int i = 1; i < 200; ++i)
    add_instance(t.scene, mesh, glm::translate(Mat4d(1.0), Vec3d(3 * i, i % 7, 0)));
  t.update(Policy::refit);
  for (int f = 1; f < 5; ++f) {
    t.scene.set_transform(7, glm::translate(Mat4d(1.0), Vec3d(21, f, 3 * f)));
    const auto s = t.update(Policy::refit);
    if (f > 1) {
      EXPECT_LT(s.nodes_refitted, 24u);
    }
    EXPECT_EQ(t.differences(std::uint64_t(f), 48), "");
  }
}

}  // namespace
}  // namespace regraft::test
