#include "regraft/accel/accelerator.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "accel/tended.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

Mat4d at(double x, double y, double z) {
  return glm::translate(Mat4d(1.0), Vec3d(x, y, z));
}

Mat4d scale(double x, double y, double z) {
  return glm::scale(Mat4d(1.0), Vec3d(x, y, z));
}

bool says(const std::vector<std::string>& list, const std::string& wanted) {
  for (const std::string& sentence : list)
    if (sentence.find(wanted) != std::string::npos) return true;
  return false;
}

TEST(Accelerator, NothingChangedMeansNothingTouched) {
  Tended t;
  add(t.scene, sphere(8, 12));
  const auto first = t.update();
  EXPECT_GT(first.nodes_rebuilt, 0u);
  const auto second = t.update();
  EXPECT_EQ(second.nodes_refitted + second.nodes_rebuilt, 0u);
  EXPECT_EQ(second.moved_instances + second.deformed_meshes, 0u);
  EXPECT_EQ(second.left_out, std::vector<std::string>{"nothing changed: no update"});
  EXPECT_EQ(second.nodes, first.nodes);
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, AMovedInstanceTouchesNoTreeOfAMesh) {
  Tended t;
  const std::uint32_t mesh = add(t.scene, sphere(16, 24));
  const std::uint32_t second = add_instance(t.scene, mesh, at(5, 0, 0));
  t.update(Policy::refit);
  t.scene.set_transform(second, at(7, 1, 0));
  const auto s = t.update(Policy::refit);
  EXPECT_EQ(s.moved_instances, 1u);
  EXPECT_EQ(s.deformed_meshes, 0u);
  EXPECT_EQ(s.nodes_rebuilt, 0u);
  EXPECT_EQ(s.nodes_refitted, 3u) << "the tree over two instances";
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, HiddenMeshesWaitUntilTheyAreShown) {
  Tended t;
  add(t.scene, sphere(4, 6));
  const Geometry g = torus(8, 8, 0.5);
  const std::uint32_t mesh = add(t.scene, g, at(3, 0, 0));
  t.update(Policy::refit);
  t.scene.set_visible(1, false);
  t.scene.set_vertices(mesh, g.scaled(2.0).vertices);
  auto s = t.update(Policy::refit);
  EXPECT_EQ(s.deformed_meshes, 0u);
  EXPECT_TRUE(says(s.left_out, "1 changed meshes hidden"));
  EXPECT_EQ(t.differences(), "");
  t.scene.set_vertices(mesh, g.scaled(0.5).vertices);
  s = t.update(Policy::refit);
  EXPECT_EQ(s.deformed_meshes + s.nodes_refitted + s.nodes_rebuilt, 0u);
  t.scene.set_visible(1, true);
  s = t.update(Policy::refit);
  EXPECT_EQ(s.deformed_meshes, 1u);
  EXPECT_GT(s.nodes_refitted, 50u);
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, AMeshRetopologisedWhileHiddenIsBuiltWhenItIsShown) {
  Tended t;
  const std::uint32_t mesh = add(t.scene, sphere(8, 12));
  add_instance(t.scene, mesh, at(3, 0, 0));
  t.update(Policy::refit);
  t.scene.set_visible(0, false);
  t.scene.set_visible(1, false);
  t.update(Policy::refit);
  t.scene.set_mesh(mesh, box({-1, -1, -1}, {1, 1, 1}).data());
  t.update(Policy::refit);
  t.scene.set_vertices(mesh, box({-1, -1, -1}, {1, 2, 1}).vertices);
  t.scene.set_visible(1, true);
  const auto s = t.update(Policy::refit);
  EXPECT_GT(s.nodes_rebuilt, 0u);
  EXPECT_EQ(s.triangles, 12u);
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, TrianglesThatWereDeadAreRevived) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended t;
    Geometry g = sphere(6, 8);
    const Geometry whole = g;
    for (int i = 0; i < 20; ++i) g.vertices[std::size_t(i)] = Vec3(0, 0, 1);
    const std::uint32_t mesh = add(t.scene, g);
    t.update(Policy::refit, layout);
    EXPECT_EQ(t.differences(), "");
    t.scene.set_vertices(mesh, whole.vertices);
    const auto s = t.update(Policy::refit, layout);
    EXPECT_GT(s.nodes_rebuilt, 0u);
    EXPECT_EQ(t.differences(), "");
  }
}

TEST(Accelerator, MeshesAddedLaterLeaveTheOthersWhereTheyAre) {
  Tended t;
  for (int i = 0; i < 40; ++i) {
    add(t.scene, sphere(3, 4), at(3 * i, 0, 0));
    t.update(i % 3 == 0 ? Policy::rebuild : Policy::refit,
             i % 5 < 3 ? Layout::two_level : Layout::flat);
    ASSERT_EQ(t.differences(std::uint64_t(i), 64), "") << i;
  }
}

TEST(Accelerator, AnotherWidthTakesEveryTreeAlong) {
  Tended t;
  const std::uint32_t mesh = add(t.scene, sphere(8, 12));
  add(t.scene, torus(8, 8, 0.5), scale(1, 1, 0));
  add_instance(t.scene, mesh, at(3, 0, 0));
  t.update();
  t.width = 4;
  t.update();
  EXPECT_EQ(t.differences(), "");
  t.width = 8;
  t.update(Policy::refit, Layout::flat);
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, ATriangleMissingWhenTheFlatTreeIsMadeIsTakenInWhenItIsBack) {
  Tended t;
  const Geometry g = soup(40, 3, 1.0, 0.4);
  const std::uint32_t mesh = add(t.scene, g);
  t.update(Policy::refit);
  Geometry broken = g;
  broken.vertices[7].x = nan;
  t.scene.set_vertices(mesh, broken.vertices);
  t.update(Policy::refit);
  t.update(Policy::refit, Layout::flat);
  EXPECT_EQ(t.differences(), "");
  t.scene.set_vertices(mesh, g.vertices);
  t.update(Policy::refit, Layout::flat);
  EXPECT_EQ(t.differences(2, 512), "");
}

TEST(Accelerator, ABakedInstanceThatWasNothingIsTakenInWhenItIsSomething) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended t;
    add(t.scene, sphere(4, 6), at(5, 0, 0));
    // A square on z = 0, seen as a line: every triangle loses its area.
    const std::uint32_t square = add_mesh(t.scene, floor_grid(2, 1.0f));
    const std::uint32_t id = add_instance(t.scene, square, scale(0, 1, 1));
    t.update(Policy::refit, layout);
    EXPECT_EQ(t.differences(), "");
    t.scene.set_transform(id, scale(1, 1, 0));
    t.update(Policy::refit, layout);
    EXPECT_EQ(t.differences(), "");
    t.scene.set_transform(id, scale(0, 1, 1));
    t.update(Policy::rebuild, layout);
    EXPECT_EQ(t.differences(), "");
    t.scene.set_transform(id, scale(1, 2, 0));
    t.update(Policy::rebuild, layout);
    EXPECT_EQ(t.differences(), "");
  }
}

TEST(Accelerator, ABakedInstanceThatStaysNothingIsNotMended) {
  for (const Policy policy : all_policies) {
    Tended t;
    add(t.scene, sphere(4, 6), at(5, 0, 0));
    const std::uint32_t square = add_mesh(t.scene, floor_grid(2, 1.0f));
    const std::uint32_t id = add_instance(t.scene, square, scale(0, 1, 1));
    for (int frame = 0; frame < 4; ++frame) {
      t.accelerator.note_rays(100'000'000);
      t.update(policy);
      EXPECT_EQ(t.differences(), "");
      t.scene.set_transform(id, scale(0, 2 + frame, 1));
    }
  }
}

TEST(Accelerator, ABakedInstanceWhoseTreeIsRebuiltChangesTheFlatTree) {
  Tended t;
  const Geometry g = soup(60, 5, 1.0, 0.4);
  Geometry flat = g;
  for (std::size_t i = 0; i < 90; ++i) flat.vertices[i].y = 0.0f;
  const std::uint32_t mesh = add(t.scene, flat, scale(1, 1, 0));
  t.update(Policy::refit, Layout::flat);
  EXPECT_EQ(t.differences(), "");
  t.scene.set_vertices(mesh, g.vertices);
  t.update(Policy::refit, Layout::flat);
  EXPECT_EQ(t.differences(2, 512), "");
}

TEST(Accelerator, AnInstanceGoesBetweenDirectAndBaked) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended t;
    const Geometry g = torus(8, 8, 0.5);
    const std::uint32_t mesh = add(t.scene, g);
    add_instance(t.scene, mesh, at(4, 0, 0));
    const double sizes[] = {1.0, 0.0, 1e-8, 0.5, 1e-7, 0.0, -2.0};
    for (const double z : sizes) {
      t.scene.set_transform(0, scale(1, 1, z));
      t.update(Policy::refit, layout);
      ASSERT_EQ(t.differences(), "") << z;
      t.scene.set_vertices(mesh, g.scaled(1.0 + z).vertices);
      t.update(Policy::refit, layout);
      ASSERT_EQ(t.differences(), "") << z;
    }
  }
}

TEST(Accelerator, AMatrixWithoutAreaIsLeftOutAndNamed) {
  Tended t;
  add(t.scene, sphere(4, 6));
  const std::uint32_t bad = add_instance(t.scene, 0, scale(1, 0, 0));
  auto s = t.update();
  EXPECT_EQ(s.instances, 1u);
  EXPECT_TRUE(says(s.warnings, "instance 1")) << s.warnings.size();
  EXPECT_EQ(t.differences(), "");
  t.scene.set_transform(bad, at(4, 0, 0));
  s = t.update();
  EXPECT_EQ(s.instances, 2u);
  EXPECT_TRUE(s.warnings.empty());
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, AMatrixThatIsNotFiniteIsLeftOutAndNamed) {
  for (const double bad : {double(nan), double(inf), 1e300}) {
    Tended t;
    add(t.scene, sphere(4, 6));
    add_instance(t.scene, 0, scale(bad, 1, 1));
    const auto s = t.update();
    EXPECT_EQ(s.instances, 1u) << bad;
    EXPECT_TRUE(says(s.warnings, "instance 1")) << bad;
    EXPECT_TRUE(std::isfinite(s.culling_efficiency)) << bad;
    EXPECT_EQ(t.differences(), "") << bad;
  }
}

TEST(Accelerator, AnInstanceThatLeavesTheRangeOfFloatsAndComesBack) {
  Tended t;
  const Geometry g = sphere(4, 6);
  const std::uint32_t mesh = add(t.scene, g);
  add(t.scene, g, at(5, 0, 0));
  t.update(Policy::refit);
  t.scene.set_transform(0, scale(1e38, 1e38, 1e38));
  auto s = t.update(Policy::refit);
  EXPECT_TRUE(says(s.warnings, "instance 0"));
  EXPECT_EQ(t.differences(), "");
  t.scene.set_transform(0, scale(1e18, 1e18, 1e18));
  t.update(Policy::refit);
  EXPECT_EQ(t.differences(), "");
  t.scene.set_vertices(mesh, g.scaled(1e20).vertices);
  s = t.update(Policy::refit);
  EXPECT_TRUE(says(s.warnings, "instance 0"));
  EXPECT_EQ(t.differences(), "");
  t.scene.set_vertices(mesh, g.vertices);
  s = t.update(Policy::refit);
  EXPECT_TRUE(s.warnings.empty());
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, TrianglesLeftOutAreCountedAndTheirMeshNamed) {
  Tended t;
  Geometry g = floor_grid(4, 1.0f);
  g.vertices[0].z = inf;
  add_mesh(t.scene, g, "cloth");
  add_instance(t.scene, 0);
  const auto s = t.update();
  EXPECT_TRUE(says(s.warnings, "'cloth': 2 triangles with non-finite vertices left out"));
  EXPECT_EQ(t.differences(), "");
}

TEST(Accelerator, TrianglesThatBecomeNonFiniteAreCountedUnderEveryPolicy) {
  for (const Policy policy : {Policy::refit, Policy::rebuild, Policy::automatic}) {
    Tended t;
    const Geometry g = floor_grid(4, 1.0f);
    add_mesh(t.scene, g, "cloth");
    add_instance(t.scene, 0);
    t.update(policy);
    Geometry broken = g;
    broken.vertices[0].z = nan;
    t.scene.set_vertices(0, broken.vertices);
    EXPECT_TRUE(says(t.update(policy).warnings, "2 triangles with non-finite vertices left out"))
        << name(policy);
    t.scene.set_vertices(0, g.vertices);
    EXPECT_TRUE(t.update(policy).warnings.empty()) << name(policy);
  }
}

}  // namespace
}  // namespace regraft::test
