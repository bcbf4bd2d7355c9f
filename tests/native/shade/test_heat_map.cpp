#include "regraft/shade/heat_map.h"

#include <gtest/gtest.h>

namespace regraft::shade {
namespace {

float luminance(const Vec3& c) {
  return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

TEST(HeatMap, MoreCostIsBrighter) {
  for (float cost = 0.0f; cost < heat_map_top; cost = cost * 1.1f + 1.0f)
    EXPECT_GT(luminance(heat_color(cost * 1.1f + 1.0f)), luminance(heat_color(cost))) << cost;
}

TEST(HeatMap, RunsFromBlackToTheTopAndNoFurther) {
  EXPECT_LT(luminance(heat_color(0.0f)), 0.002f);
  EXPECT_EQ(heat_color(heat_map_top), heat_color(1e30f));
  EXPECT_EQ(heat_color(-5.0f), heat_color(0.0f));
  EXPECT_NEAR(heat_color(heat_map_top).x, 0.9737f, 1e-4f);
}

TEST(HeatMap, IsLogarithmic) {
  // log2(1 + 63) is half of log2(1 + 4095): the middle of the map.
  const Vec3 middle = heat_color(63.0f);
  EXPECT_NEAR(middle.x, 0.5005f, 1e-3f);
  EXPECT_NEAR(middle.y, 0.0383f, 1e-3f);
}

}  // namespace
}  // namespace regraft::shade
