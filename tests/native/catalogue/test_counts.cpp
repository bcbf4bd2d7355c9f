#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "accel/tended.h"
#include "catalogue/size.h"
#include "trace/bed.h"

// Catalogue A: how many things there are, and what they are made of.

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

Mat4d at(double x, double y, double z) {
  return glm::translate(Mat4d(1.0), Vec3d(x, y, z));
}

TEST(Counts, AnEmptySceneIsMissedByEveryRay) {
  Bed bed;
  EXPECT_EQ(bed.problems(1, 70), "");
  const Ray ray;
  EXPECT_FALSE(bed.hits(std::span(&ray, 1))[0].hit());
}

TEST(Counts, OneTriangleIsHitWhateverTheTree) {
  Bed bed;
  bed.add(triangle({0, 0, 0}, {1, 0, 0.5f}, {0, 1, 0.25f}));
  EXPECT_EQ(bed.problems(2, 96), "");
}

TEST(Counts, OfEqualTrianglesTheOneWithTheLowestIdIsHit) {
  Bed bed;
  Geometry twice = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  twice.triangles.push_back(twice.triangles[0]);
  const std::uint32_t mesh = bed.add(twice);
  add_instance(bed.scene, mesh);
  ASSERT_EQ(bed.problems(3, 64), "");
  const Ray ray{{0.25, 0.25, 1}, {0, 0, -1}};
  const Found found = bed.hits(std::span(&ray, 1))[0];
  EXPECT_EQ(found.instance, 0u);
  EXPECT_EQ(found.prim, 0u);
}

TEST(Counts, MeshesWithoutTrianglesBesideAFullOneAreIgnored) {
  Bed bed;
  bed.add({});
  bed.add(sphere(5, 7), at(1, 0, 0));
  bed.add({sphere(5, 7).vertices, {}}, at(1, 0, 0));
  ASSERT_EQ(bed.problems(4, 64), "");
  for (const auto& setup : setups()) EXPECT_EQ(bed.statistics(setup).triangles, 56u) << setup;
}

TEST(Counts, AThousandEmptyObjectsCostNoNodesAndLittleMemoryEach) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended t;
    add(t.scene, sphere(5, 7));
    const accel::UpdateStatistics alone = t.update(Policy::automatic, layout);
    for (int i = 0; i < 1000; ++i) add(t.scene, {}, at(i, 0, 0));
    const accel::UpdateStatistics among = t.update(Policy::automatic, layout);
    EXPECT_EQ(among.nodes, alone.nodes);
    EXPECT_LT(among.memory_bytes, alone.memory_bytes + 1000 * 4096);
    EXPECT_EQ(t.differences(1, 32), "");
  }
}

TEST(Counts, AVertexSharedByVeryManyTrianglesLosesNoRay) {
  const Geometry fan = closed_fan(very_many);
  std::vector<Ray> rays;
  Random random(5);
  for (int i = 0; i < 4; ++i) {
    const Vec3d from = Vec3d(0, 0, -0.2) + 0.1 * random.in_box(1.0);
    rays.push_back({from, Vec3d(0, 0, i % 3 == 0 ? -1.0 : 0.25) - from});
  }
  Tended t;
  add(t.scene, fan);
  t.update(Policy::automatic, Layout::two_level);
  const std::vector<Found> wanted = hits_anew(t.scene, rays);
  for (const Found& found : wanted) EXPECT_TRUE(found.hit());
  EXPECT_EQ(difference(t.accelerator.view(), t.width, rays, wanted), "");
  t.width = 4;
  accel::UpdateOptions cells;
  cells.structure = accel::Structure::kdtree;
  t.accelerator.update(t.scene, {}, cells, t.width, pool(2));
  EXPECT_EQ(difference(t.accelerator.view(), t.width, rays, wanted), "");
}

TEST(Counts, TopologyMayChangeInEveryFrame) {
  Bed bed(policies());
  const std::uint32_t mesh = bed.add(sphere(5, 7));
  bed.add(torus(6, 5, 0.4), at(1, 0, 0));
  for (int frame = 0; frame < 6; ++frame) {
    const Geometry g =
        frame % 3 == 0 ? torus(5, 4, 0.3) : sphere(unsigned(3 + frame), unsigned(9 - frame));
    bed.scene.set_mesh(mesh, g.data());
    bed.note_rays(1'000'000);
    ASSERT_EQ(bed.problems(std::uint64_t(frame), 16), "") << "frame " << frame;
  }
}

TEST(Counts, TrianglesMayAllGoAndComeBack) {
  Bed bed(policies());
  const Geometry whole = sphere(5, 7);
  const std::uint32_t mesh = bed.add(whole);
  ASSERT_EQ(bed.update(), "");
  for (int round = 0; round < 2; ++round) {
    bed.scene.set_mesh(mesh, {});
    ASSERT_EQ(bed.problems(1, 16), "");
    bed.scene.set_mesh(mesh, whole.data());
    ASSERT_EQ(bed.problems(2, 32), "");
  }
}

TEST(Counts, AnObjectHiddenAndShownByTurnsIsRightWhenItIsThere) {
  Bed bed(policies());
  const Geometry g = sphere(6, 8);
  bed.add(torus(7, 5, 0.4));
  const std::uint32_t mesh = bed.add(g, at(1, 0, 0));
  for (int frame = 0; frame < 6; ++frame) {
    bed.scene.set_visible(1, frame % 2 == 0);
    bed.deform(mesh, g.scaled(1.0 + 0.1 * frame));
    bed.note_rays(1'000'000);
    ASSERT_EQ(bed.problems(std::uint64_t(frame), 16), "") << "frame " << frame;
  }
}

}  // namespace
}  // namespace regraft::test
