#include "regraft/accel/accelerator.h"

#include <gtest/gtest.h>

#include "regraft/bvh/sah.h"
#include "regraft/kdtree/origin_metric.h"
#include "trace/compare.h"

namespace regraft::test {
namespace {

accel::Quality quality_of(const Scene& scene, accel::Layout layout) {
  Executor one(1);
  accel::Accelerator accelerator;
  accel::UpdateOptions options;
  options.layout = layout;
  accelerator.update(scene, scene.changes(), options, 8, one);
  return accelerator.quality(scene, false, one);
}

TEST(OriginCost, SumsTheChancesOfNodesAsTheyAreDefined) {
  Scene scene;
  const Aabb low{Vec3(0, 0, 0), Vec3(1, 1, 1)}, high{Vec3(7, 1, 2), Vec3(8, 3, 3)};
  for (const Aabb& b : {low, high}) add(scene, box(b.lo, b.hi));
  Aabb all = low;
  all.extend(high);
  const accel::Quality q = quality_of(scene, accel::Layout::two_level);
  const auto chance = [&](const Aabb& b) {
    return kdtree::visit_probability(kdtree::OriginMetric::regions6, all, b);
  };
  // Of each box at least its root, at most all its triangles.
  const double roots = chance(low) + chance(high);
  EXPECT_GT(q.origin_cost, 1.0 + roots);
  EXPECT_LT(q.origin_cost, 1.0 + roots * (11.0 + 12.0 * bvh::CostModel{}.leaf));
}

TEST(OriginCost, IsThatOfOneLeafForOneTriangle) {
  Scene scene;
  add(scene, triangle({0, 0, 0}, {1, 0, 1}, {0, 1, 2}));
  for (const auto layout : {accel::Layout::two_level, accel::Layout::flat})
    EXPECT_NEAR(quality_of(scene, layout).origin_cost, bvh::CostModel{}.leaf, 1e-6);
}

TEST(OriginCost, DoesNotDependOnScaleAndPlace) {
  const Geometry g = soup(300, 5, 10.0, 0.5);
  Scene here, there;
  add(here, g);
  add(there, g.scaled(0.125).moved({64, -32, 16}));
  const double cost = quality_of(here, accel::Layout::flat).origin_cost;
  EXPECT_NEAR(quality_of(there, accel::Layout::flat).origin_cost / cost, 1.0, 0.01);
}

}  // namespace
}  // namespace regraft::test
