#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "accel/tended.h"
#include "catalogue/size.h"
#include "trace/bed.h"

// Catalogue F: matrices of instances.

namespace regraft::test {
namespace {

using accel::Policy;

Mat4d at(double x, double y, double z) {
  return glm::translate(Mat4d(1.0), Vec3d(x, y, z));
}

Mat4d scale(double x, double y, double z) {
  return glm::scale(Mat4d(1.0), Vec3d(x, y, z));
}

/// Rays at a ball placed by `m`, among them such that must hit it.
struct Placed {
  Bed bed;
  std::vector<Ray> sure;

  explicit Placed(const Mat4d& m, const Geometry& g = sphere(8, 12)) {
    bed.add(g, m);
    Random random(11);
    const auto world = [&](const Vec3d& p) { return Vec3d(m * glm::dvec4(p, 1.0)); };
    for (int i = 0; i < 48; ++i) {
      const Vec3d from = 3.0 * random.way(), to = 0.4 * random.in_box(1.0);
      sure.push_back({world(from), world(to) - world(from)});
    }
  }
  /// The first problem, or "". Every ray of `sure` must hit.
  std::string problems() {
    std::string error = bed.problems(11, 72);
    if (error.empty()) error = bed.differences(sure);
    if (error.empty()) error = bed.complaints(sure);
    const std::vector<Found> found = bed.hits(sure);
    for (std::size_t i = 0; i < found.size() && error.empty(); ++i)
      if (!found[i].hit()) error = text("lost: ", sure[i]);
    return error;
  }
};

TEST(Transforms, AScaleOfZeroOnOneAxisMakesAFlatThingThatIsHit) {
  for (const Mat4d& m : {scale(1, 1, 0), scale(0, 1, 1), at(1, 2, 3) * scale(2, 0, -1)}) {
    Bed bed;
    bed.add(sphere(8, 12), m);
    ASSERT_EQ(bed.problems(1, 96), "");
    std::size_t hits = 0;
    for (const Found& found : bed.hits(nasty_rays(SceneOracle(bed.scene), 2, 96)))
      hits += found.hit();
    EXPECT_GT(hits, 20u);
  }
}

TEST(Transforms, ScalesOfZeroOnTwoOrThreeAxesAreLeftOutAndCounted) {
  for (const Mat4d& m : {scale(1, 0, 0), scale(0, 0, 1), scale(0, 0, 0)}) {
    Bed bed;
    bed.add(sphere(5, 7));
    bed.add(sphere(5, 7), m);
    ASSERT_EQ(bed.problems(2, 48), "");
    for (const auto& setup : setups()) {
      EXPECT_EQ(bed.statistics(setup).instances, 1u) << setup;
      EXPECT_TRUE(bed.warns(setup, "instance 1")) << setup;
    }
  }
}

TEST(Transforms, ANegativeScaleTurnsAThingInsideOutAndNoMore) {
  EXPECT_EQ(Placed(scale(-1, 1, 1)).problems(), "");
  EXPECT_EQ(Placed(scale(-1, -2, -3)).problems(), "");
}

TEST(Transforms, AShearOfTenThousandIsRight) {
  for (int axis = 0; axis < 3; ++axis) {
    Mat4d m(1.0);
    m[axis][(axis + 1) % 3] = 1e4;
    EXPECT_EQ(Placed(m).problems(), "") << axis;
  }
}

TEST(Transforms, AScaleOfATenThousandthOnOneAxisAndTenThousandOnAnotherIsRight) {
  const Mat4d turned = glm::rotate(Mat4d(1.0), 1.0, glm::normalize(Vec3d(1, 2, 3)));
  EXPECT_EQ(Placed(scale(1e-4, 1e4, 1)).problems(), "");
  // Baked to world space, where no float resolves its thickness: found within their error.
  Bed baked;
  baked.add(sphere(8, 12), turned * scale(1e4, 1, 1e-4));
  EXPECT_EQ(baked.problems(11, 96), "");
}

TEST(Transforms, AUniformScaleWithADeterminantOf1e30thIsNotTakenForSingular) {
  Placed tiny(scale(1e-10, 1e-10, 1e-10));
  EXPECT_EQ(tiny.problems(), "");
  for (const auto& setup : setups()) EXPECT_EQ(tiny.bed.statistics(setup).instances, 1u) << setup;
}

TEST(Transforms, TenThousandGroupsInsideEachOtherAreAsGoodAsNone) {
  Bed bed;
  const std::uint32_t mesh = add_mesh(bed.scene, sphere(5, 7));
  Instance deep;
  deep.mesh = mesh;
  for (int level = 0; level < 10'000; ++level) deep.group = bed.scene.add_group(deep.group, "");
  bed.scene.add_instance(deep);
  add_instance(bed.scene, mesh, at(1, 0, 0));
  EXPECT_EQ(bed.problems(6, 64), "");
}

TEST(Transforms, ThePlaceOfAChainOfTenThousandSmallTurnsDoesNotDrift) {
  const Vec3d axis = glm::normalize(Vec3d(1, 2, 3));
  const double angle = 1e-3;
  Mat4d chain(1.0);
  for (int i = 0; i < 10'000; ++i) chain = chain * glm::rotate(Mat4d(1.0), angle, axis);
  const Mat4d at_once = glm::rotate(Mat4d(1.0), 10'000 * angle, axis);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(chain[c][r], at_once[c][r], 1e-9);
  EXPECT_EQ(Placed(chain).problems(), "");
}

TEST(Transforms, AChainThatShrinksIsRightAndOneThatOverflowsIsNamed) {
  Mat4d shrinking(1.0), growing(1.0);
  for (int i = 0; i < 10'000; ++i) {
    shrinking = shrinking * scale(0.999, 0.999, 0.999);
    growing = growing * scale(2, 2, 2);
  }
  EXPECT_EQ(Placed(shrinking).problems(), "");
  for (const Mat4d& m : {growing, scale(0x1p200, 0x1p200, 0x1p200)}) {
    Bed bed;
    bed.add(sphere(5, 7));
    bed.add(sphere(5, 7), m);
    ASSERT_EQ(bed.problems(3, 48), "");
    for (const auto& setup : setups()) EXPECT_TRUE(bed.warns(setup, "instance 1")) << setup;
  }
}

TEST(Transforms, InstancesOfInstancesFiveLevelsDeepAreRight) {
  Bed bed;
  const std::uint32_t mesh = add_mesh(bed.scene, sphere(4, 5));
  const Mat4d left = at(-1.1, 0.2, 0) * scale(0.6, 0.5, -0.6);
  const Mat4d right = glm::rotate(at(1.1, 0, 0.3) * scale(0.6, 0.6, 0.6), 0.7, Vec3d(0, 0.6, 0.8));
  for (unsigned path = 0; path < 32; ++path) {
    Mat4d m(1.0);
    for (unsigned level = 0; level < 5; ++level) m = m * ((path >> level & 1u) != 0 ? right : left);
    add_instance(bed.scene, mesh, m);
  }
  EXPECT_EQ(bed.problems(4, 96), "");
}

TEST(Transforms, VeryManyInstancesOfOneMeshAreRightAndTakeLittleMemoryEach) {
  Tended t;
  t.width = 4;
  const std::uint32_t mesh =
      add_mesh(t.scene, triangle({0, 0, 0}, {0.4f, 0, 0.1f}, {0.1f, 0.4f, 0}));
  std::vector<Instance> crowd(very_many);
  Random random(5);
  for (Instance& instance : crowd) {
    instance.mesh = mesh;
    instance.object_to_world =
        glm::rotate(glm::translate(Mat4d(1.0), random.in_box(12.0)), 3.0, random.way());
  }
  t.scene.add_instances(std::move(crowd));
  const accel::UpdateStatistics s = t.update(Policy::automatic);
  EXPECT_EQ(s.instances, very_many);
  EXPECT_LT(s.memory_bytes, 1024u * very_many);
  std::vector<Ray> rays;
  for (int i = 0; i < 6; ++i) rays.push_back({random.in_box(12.0), random.way()});
  const std::vector<Found> wanted = hits_anew(t.scene, rays);
  EXPECT_EQ(difference(t.accelerator.view(), t.width, rays, wanted), "");
  accel::UpdateOptions cells;
  cells.structure = accel::Structure::kdtree;
  t.accelerator.update(t.scene, {}, cells, t.width, pool(2));
  EXPECT_EQ(difference(t.accelerator.view(), t.width, rays, wanted), "");
}

}  // namespace
}  // namespace regraft::test
