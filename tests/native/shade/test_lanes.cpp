#include "regraft/shade/lanes.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

namespace regraft::shade {
namespace {

TEST(Lanes, SineAndCosineOfATurnAreThoseOfTheLibrary) {
  for (int i = 0; i < 100000; ++i) {
    const float u = float(i) / 100000.0f;
    float sine, cosine;
    sincos_turn(u, sine, cosine);
    EXPECT_NEAR(sine, std::sin(2.0 * std::numbers::pi * double(u)), 1e-6);
    EXPECT_NEAR(cosine, std::cos(2.0 * std::numbers::pi * double(u)), 1e-6);
  }
}

TEST(Lanes, AFrameIsOrthonormalWhereverItsNormalPoints) {
  const float s = std::sqrt(1.0f / 3.0f);
  const float directions[][3] = {{0, 0, 1}, {0, 0, -1},  {1, 0, 0},      {0, -1, 0},
                                 {s, s, s}, {-s, s, -s}, {1e-4f, 0, -1}, {0, 1, -1e-20f}};
  for (const auto& n : directions) {
    const Frame3 f(n[0], n[1], n[2]);
    const float t[3] = {f.tx, f.ty, f.tz}, b[3] = {f.bx, f.by, f.bz};
    float tt = 0, bb = 0, tb = 0, tn = 0, bn = 0;
    for (int k = 0; k < 3; ++k) {
      tt += t[k] * t[k], bb += b[k] * b[k], tb += t[k] * b[k], tn += t[k] * n[k], bn += b[k] * n[k];
    }
    EXPECT_NEAR(tt, 1.0f, 1e-5f);
    EXPECT_NEAR(bb, 1.0f, 1e-5f);
    EXPECT_NEAR(std::fabs(tb) + std::fabs(tn) + std::fabs(bn), 0.0f, 1e-5f);
  }
}

RC_GTEST_PROP(Lanes, MasksAndWeightsSayTheSame, (std::uint64_t mask)) {
  FloatLanes weights;
  set_weights(mask, weights);
  for (std::uint32_t i = 0; i < lane_count; ++i)
    RC_ASSERT(weights[i] == (has_lane(mask, i) ? 1.0f : 0.0f));
  RC_ASSERT(lanes_above(weights, 0.5f) == mask);
  RC_ASSERT(lanes_below(weights.value, 0.5f) == ~mask);
  LaneMask walked = 0;
  for_each_lane(mask, [&](std::uint32_t i) { walked |= LaneMask(1) << i; });
  RC_ASSERT(walked == mask);
}

}  // namespace
}  // namespace regraft::shade
