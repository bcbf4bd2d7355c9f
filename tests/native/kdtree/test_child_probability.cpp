#include "regraft/kdtree/child_probability.h"

#include <gtest/gtest.h>

namespace regraft::test {
namespace {

using kdtree::ChildProbability;
using kdtree::OriginMetric;
using kdtree::visit_probability;

constexpr OriginMetric all_metrics[] = {OriginMetric::sah, OriginMetric::regions6,
                                        OriginMetric::regions26, OriginMetric::faces,
                                        OriginMetric::exact};
const Aabb hall{Vec3(-1, 0, 2), Vec3(9, 6, 5)};

Aabb with_hi(Aabb box, int axis, float position) {
  box.hi[axis] = position;
  return box;
}
Aabb with_lo(Aabb box, int axis, float position) {
  box.lo[axis] = position;
  return box;
}

TEST(ChildProbability, IsTheRatioOfTheChildsToTheVoxels) {
  const Aabb voxels[] = {hall, {Vec3(0, 1, 2), Vec3(4, 3, 4)}, {Vec3(-1, 0, 3), Vec3(9, 6, 3)}};
  for (const OriginMetric metric : all_metrics)
    for (const Aabb& voxel : voxels)
      for (int axis = 0; axis < 3; ++axis)
        for (const float part : {0.0f, 0.125f, 0.5f, 0.875f, 1.0f}) {
          const float x = voxel.lo[axis] + part * (voxel.hi[axis] - voxel.lo[axis]);
          const ChildProbability::Pair p = ChildProbability(voxel, metric, hall).at(axis, x);
          const double whole = visit_probability(metric, hall, voxel);
          const double left = visit_probability(metric, hall, with_hi(voxel, axis, x));
          const double right = visit_probability(metric, hall, with_lo(voxel, axis, x));
          EXPECT_NEAR(p.left, left / whole, 1e-12) << int(metric) << " " << axis << " " << part;
          EXPECT_NEAR(p.right, right / whole, 1e-12) << int(metric) << " " << axis << " " << part;
        }
}

TEST(ChildProbability, FallsBackToAreasWhereTheOriginsHaveNoVolumeOrSeeNothing) {
  const Aabb voxel{Vec3(20), Vec3(22, 23, 24)};
  const Aabb flat{Vec3(0), Vec3(30, 30, 0)};
  for (const OriginMetric metric : all_metrics)
    for (const Aabb& origins : {hall, flat}) {
      const ChildProbability probability(voxel, metric, origins);
      EXPECT_TRUE(probability.linear());
      EXPECT_EQ(probability.at(1, 21).left, ChildProbability(voxel).at(1, 21).left);
    }
}

TEST(ChildProbability, OfWhatLiesOutsideTheOriginsIsZero) {
  const Aabb voxel{Vec3(-10, 0, 2), Vec3(20, 6, 5)};
  for (const OriginMetric metric :
       {OriginMetric::regions6, OriginMetric::faces, OriginMetric::exact}) {
    const ChildProbability probability(voxel, metric, hall);
    EXPECT_EQ(probability.at(0, -5).left, 0.0);
    EXPECT_EQ(probability.at(0, -5).right, 1.0);
    EXPECT_EQ(probability.at(0, 15).left, 1.0);
    EXPECT_EQ(probability.at(0, 15).right, 0.0);
  }
}

TEST(ChildProbability, OfALineAndAPointAreRatiosOfLengths) {
  const ChildProbability line({Vec3(0), Vec3(4, 0, 0)});
  EXPECT_EQ(line.at(0, 1).left, 0.25);
  EXPECT_EQ(line.at(0, 1).right, 0.75);
  const ChildProbability point({Vec3(1), Vec3(1)});
  EXPECT_EQ(point.at(2, 1).left, 1.0);
}

TEST(ChildProbability, RisesWithTheChild) {
  for (const OriginMetric metric : all_metrics) {
    const Aabb voxel{Vec3(0, 1, 2), Vec3(4, 3, 4)};
    const ChildProbability probability(voxel, metric, hall);
    ChildProbability::Pair last{0.0, 2.0};
    for (int i = 0; i <= 200; ++i) {
      const ChildProbability::Pair p = probability.at(0, 4.0 * i / 200.0);
      EXPECT_GE(p.left, last.left);
      EXPECT_LE(p.right, last.right);
      last = p;
    }
  }
}

}  // namespace
}  // namespace regraft::test
