#include "regraft/accel/vertex_bounds.h"

#include <gtest/gtest.h>

#include "trace/compare.h"

namespace regraft::test {
namespace {

std::vector<Vec3> points(std::size_t count) {
  Random random(count);
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < count; ++i) result.emplace_back(random.in_box(3.0));
  return result;
}

Aabb box_of(const std::vector<Vec3>& vertices) {
  Aabb box;
  for (const Vec3& p : vertices) box.extend(p);
  return box;
}

TEST(VertexBounds, HoldAnyNumberOfPointsExactly) {
  for (const std::size_t count : {0, 1, 2, 3, 4, 5, 7, 8, 1023, 40001})
    for (const unsigned threads : {1u, 5u}) {
      const std::vector<Vec3> all = points(count);
      const auto box = accel::vertex_bounds(all, pool(threads));
      ASSERT_TRUE(box.has_value());
      EXPECT_EQ(*box, box_of(all)) << count;
    }
}

TEST(VertexBounds, AreNotKnownOfPointsThatAreNotFinite) {
  for (const std::size_t at : {0, 6, 20000, 40000})
    for (const float value : {nan, inf, -inf}) {
      std::vector<Vec3> all = points(40001);
      all[at][int(at % 3)] = value;
      EXPECT_FALSE(accel::vertex_bounds(all, pool(2)).has_value()) << at;
    }
}

}  // namespace
}  // namespace regraft::test
