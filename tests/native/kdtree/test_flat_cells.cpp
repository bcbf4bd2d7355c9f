#include <gtest/gtest.h>

#include <cmath>

#include "kdtree/stand.h"
#include "regraft/kdtree/seeded_builder.h"
#include "regraft/kdtree/validate.h"
#include "trace/scene_oracle.h"

// Geometry that lies in the planes a k-d tree is cut by (catalogue E), and rays in them.

namespace regraft::test {
namespace {

using kdtree::Config;
using kdtree::KdTree;

/// The first thing wrong with what trees of every configuration answer, or "".
std::string problems(Stand& stand, std::span<const Ray> more = {}) {
  std::vector<Ray> rays = nasty_rays(SceneOracle(stand.scene), 3, 96);
  rays.insert(rays.end(), more.begin(), more.end());
  const HierarchyView& view = stand.hierarchy();
  for (const Config& config : all_configurations()) {
    const KdTree tree(view, config, pool(1));
    std::string error = stand.differences(tree, rays);
    tree.complete(pool(1));
    if (error.empty()) error = kdtree::validate(tree);
    if (!error.empty()) return text(name(config), ": ", error);
  }
  return "";
}

TEST(FlatCells, AFloorCutByPlanesAtEveryLineOfItsGrid) {
  Stand stand;
  stand.add(floor_grid(12, 6.0f));
  std::vector<Ray> rays;
  for (int i = -6; i <= 6; ++i) {
    rays.push_back({{double(i), 0.5, 3}, {0, 0, -1}});
    rays.push_back({{double(i), 0.5, 3}, {-0.0, -0.0, -1}});
    rays.push_back({{double(i), -9, 0}, {0, 1, 0}});
    rays.push_back({{double(i), -9, 1}, {0, 9, -1}});
  }
  EXPECT_EQ(problems(stand, rays), "");
}

TEST(FlatCells, TwoFloorsInOnePlaceAreHitInTheOrderOfTheirIds) {
  Stand stand;
  stand.add(floor_grid(6, 3.0f));
  stand.add(floor_grid(6, 3.0f));
  ASSERT_EQ(problems(stand), "");
  const Ray ray{{0.3, 0.2, 5}, {0, 0, -1}};
  EXPECT_EQ(hits_anew(stand.scene, std::span(&ray, 1))[0].instance, 0u);
}

TEST(FlatCells, EverythingOnOneLineHasNothingToHit) {
  Stand stand;
  Geometry g;
  for (int i = 0; i < 20; ++i) {
    const float x = float(i);
    g += triangle({x, 0, 0}, {x + 1, 0, 0}, {x + 3, 0, 0});
  }
  stand.add(g);
  EXPECT_EQ(problems(stand, crossing_rays(1, 32, 10.0)), "");
}

TEST(FlatCells, BoxesThatAbutAreFoundOnceAtTheirCommonPlane) {
  Stand stand;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z) stand.add(box(Vec3(x, y, z), Vec3(x + 1, y + 1, z + 1)));
  std::vector<Ray> rays;
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 4; ++j) {
      rays.push_back({{double(i), double(j), 9}, {0, 0, -1}});
      rays.push_back({{-3, double(i), double(j)}, {1, 0, 0}});
    }
  EXPECT_EQ(problems(stand, rays), "");
}

TEST(FlatCells, PlanesOneStepFromAFace) {
  Stand stand;
  const float next = std::nextafter(1.0f, 2.0f);
  stand.add(box({0, 0, 0}, {1, 1, 1}));
  stand.add(box({next, 0, 0}, {2, 1, 1}));
  stand.add(box({1, 0, 0}, {next, 1, 1}));
  std::vector<Ray> rays;
  for (const double x : {1.0, double(next), 0.5 * (1.0 + next)})
    for (const double way : {-1.0, 1.0}) rays.push_back({{x, 0.5, -3.0 * way}, {0, 0, way}});
  EXPECT_EQ(problems(stand, rays), "");
}

TEST(FlatCells, AVoxelWithoutWidthIsNeverSplitThere) {
  Stand stand;
  stand.add(floor_grid(8, 4.0f));
  const kdtree::SeededBuilder builder(stand.hierarchy(), {});
  for (int axis = 0; axis < 3; ++axis) {
    Aabb voxel{Vec3(-4.0f), Vec3(4.0f)};
    voxel.lo[axis] = voxel.hi[axis] = 0.0f;
    const kdtree::Built built = builder.build(builder.seed(voxel, 0, 1e9));
    EXPECT_NE(built.axis, axis);
    EXPECT_TRUE(built.axis >= 0 || !built.prims.empty());
  }
}

TEST(FlatCells, AnOriginFarFromASmallSceneFindsItStill) {
  Stand stand;
  stand.add(sphere(8, 12));
  stand.add(floor_grid(4, 2.0f));
  std::vector<Ray> rays;
  Random random(2);
  for (const double far : {1e3, 1e6, 1e9})
    for (int i = 0; i < 16; ++i) {
      const Vec3d from = far * random.way();
      rays.push_back({from, random.in_box(0.7) - from});
    }
  EXPECT_EQ(problems(stand, rays), "");
}

}  // namespace
}  // namespace regraft::test
