#include "regraft/kdtree/origin_choice.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace regraft::test {
namespace {

using kdtree::choose_origin_metric;
using kdtree::OriginChoice;
using kdtree::OriginMetric;

const Aabb room{Vec3(0), Vec3(10, 6, 3)};
const Vec3 camera(5, 1, 1.7f);

std::vector<Vec3> points(const Aabb& in, int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit;
  std::vector<Vec3> result;
  for (int i = 0; i < count; ++i)
    result.push_back(in.lo + Vec3(unit(random), unit(random), unit(random)) * (in.hi - in.lo));
  return result;
}

TEST(OriginChoice, InsideARoomIsTheFastMetricOverTheRoom) {
  const OriginChoice choice = choose_origin_metric(points(room, 1000), room, camera);
  EXPECT_EQ(choice.metric, OriginMetric::regions6);
  EXPECT_TRUE(room.contains(choice.origins));
  EXPECT_GT(half_area(choice.origins), 0.9 * half_area(room));
}

TEST(OriginChoice, WithTheCameraOutsideIsAreas) {
  EXPECT_EQ(choose_origin_metric(points(room, 1000), room, Vec3(30)).metric, OriginMetric::sah);
}

TEST(OriginChoice, WithMostRaysFromALightOutsideIsAreas) {
  for (const Vec3& light : {Vec3(0, 0, 100), Vec3(0, 0, INFINITY)}) {
    std::vector<Vec3> pilot = points(room, 400);
    pilot.resize(900, light);
    EXPECT_EQ(choose_origin_metric(pilot, room, camera).metric, OriginMetric::sah);
    pilot.resize(600);
    EXPECT_EQ(choose_origin_metric(pilot, room, camera).metric, OriginMetric::regions6);
  }
}

TEST(OriginChoice, IsNotStretchedByAFewOriginsOnABackdrop) {
  const Aabb sky{Vec3(-10000), Vec3(10000)};
  std::vector<Vec3> pilot = points(room, 990);
  for (const Vec3& far : points(sky, 10)) pilot.push_back(far);
  const OriginChoice choice = choose_origin_metric(pilot, sky, camera);
  EXPECT_EQ(choice.metric, OriginMetric::regions6);
  EXPECT_LT(half_area(choice.origins), 1.01 * half_area(room));
}

TEST(OriginChoice, WithoutVolumeOrRaysIsAreas) {
  const Aabb flat{Vec3(0), Vec3(10, 6, 0)};
  EXPECT_EQ(choose_origin_metric(points(flat, 100), flat, Vec3(1, 1, 0)).metric, OriginMetric::sah);
  EXPECT_EQ(choose_origin_metric({}, room, camera).metric, OriginMetric::sah);
  EXPECT_EQ(choose_origin_metric(points(room, 100), Aabb{}, camera).metric, OriginMetric::sah);
}

}  // namespace
}  // namespace regraft::test
