#include "regraft/simd/float_n.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "regraft/simd/dispatch.h"
#include "simd/lanes.h"

namespace regraft::test {
namespace {

using simd::Isa;

const Instructions& instructions(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::sse:
      return instructions_sse;
    case Isa::avx2:
      return instructions_avx2;
    case Isa::avx512:
      return instructions_avx512;
#endif
    default:
      return instructions_scalar;
  }
}

/// Every special float beside ordinary ones.
std::vector<float> values() {
  using Limits = std::numeric_limits<float>;
  std::vector<float> v{0.0f,          1.0f,          1.5f,
                       3.0f,          1e-40f,        Limits::denorm_min(),
                       Limits::min(), Limits::max(), Limits::infinity(),
                       0.1f,          16777217.0f,   1e20f};
  for (const float x : std::vector<float>(v)) v.push_back(-x);
  v.push_back(Limits::quiet_NaN());
  return v;
}

bool same(float a, float b) {
  return (std::isnan(a) && std::isnan(b)) ||
         std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// Calls `check(a, b)` with arrays of `width` floats until every pair of values has met in every
/// lane.
template <typename Check>
void for_all_pairs(int width, const Check& check) {
  const std::vector<float> all = values();
  std::vector<float> a, b;
  for (const float x : all)
    for (std::size_t shift = 0; shift < all.size(); ++shift) {
      a.assign(std::size_t(width), x);
      b.clear();
      for (std::size_t i = 0; i < std::size_t(width); ++i)
        b.push_back(all[(i + shift) % all.size()]);
      check(a.data(), b.data());
      check(b.data(), a.data());
    }
}

class FloatN : public testing::TestWithParam<Isa> {
 protected:
  template <typename Expected>
  void expect(Lanes::Binary Lanes::*op, const Expected& expected) {
    for (const Lanes& lanes : instructions(GetParam()).lanes)
      for_all_pairs(lanes.width, [&](const float* a, const float* b) {
        float r[16];
        (lanes.*op)(a, b, r);
        for (int i = 0; i < lanes.width; ++i)
          ASSERT_TRUE(same(r[i], expected(a[i], b[i])))
              << a[i] << " and " << b[i] << " gave " << r[i] << " in lane " << i;
      });
  }
  template <typename Expected>
  void expect_bits(Lanes::Compare Lanes::*op, const Expected& expected) {
    for (const Lanes& lanes : instructions(GetParam()).lanes)
      for_all_pairs(lanes.width, [&](const float* a, const float* b) {
        std::uint32_t wanted = 0;
        for (int i = 0; i < lanes.width; ++i) wanted |= std::uint32_t(expected(a[i], b[i])) << i;
        ASSERT_EQ((lanes.*op)(a, b), wanted) << a[0] << " and " << b[0] << " first";
      });
  }
};

INSTANTIATE_TEST_SUITE_P(Isas, FloatN, testing::ValuesIn(simd::available_isas()),
                         [](const auto& isa) { return std::string(simd::name(isa.param)); });

TEST_P(FloatN, ArithmeticIsThatOfScalarsInEveryLane) {
  expect(&Lanes::add, [](float a, float b) { return a + b; });
  expect(&Lanes::subtract, [](float a, float b) { return a - b; });
  expect(&Lanes::multiply, [](float a, float b) { return a * b; });
  expect(&Lanes::divide, [](float a, float b) { return a / b; });
}

TEST_P(FloatN, MinAndMaxIgnoreANaNInTheFirstAndKeepOneInTheSecond) {
  expect(&Lanes::min, [](float a, float b) { return a < b ? a : b; });
  expect(&Lanes::max, [](float a, float b) { return a > b ? a : b; });
}

TEST_P(FloatN, ComparisonsGiveABitALaneAndAreFalseWithNaN) {
  expect_bits(&Lanes::less, [](float a, float b) { return a < b; });
  expect_bits(&Lanes::less_equal, [](float a, float b) { return a <= b; });
  expect_bits(&Lanes::equal, [](float a, float b) { return a == b; });
  expect_bits(&Lanes::greater, [](float a, float b) { return a > b; });
  expect_bits(&Lanes::greater_equal, [](float a, float b) { return a >= b; });
}

TEST_P(FloatN, BroadcastFillsEveryLane) {
  for (const Lanes& lanes : instructions(GetParam()).lanes)
    for (const float x : values()) {
      float r[16];
      lanes.broadcast(x, r);
      for (int i = 0; i < lanes.width; ++i) EXPECT_TRUE(same(r[i], x));
    }
}

TEST_P(FloatN, SignBitsSeeZerosAndNaNsToo) {
  for (const Lanes& lanes : instructions(GetParam()).lanes)
    for_all_pairs(lanes.width, [&](const float* a, const float*) {
      std::uint32_t wanted = 0;
      for (int i = 0; i < lanes.width; ++i) wanted |= std::uint32_t(std::signbit(a[i])) << i;
      ASSERT_EQ(lanes.sign_bits(a), wanted) << a[0] << " first";
    });
}

TEST_P(FloatN, AbsClearsTheSignOfEveryValue) {
  for (const Lanes& lanes : instructions(GetParam()).lanes)
    for_all_pairs(lanes.width, [&](const float* a, const float*) {
      float result[16];
      lanes.abs(a, result);
      for (int i = 0; i < lanes.width; ++i) {
        ASSERT_TRUE(same(result[i], std::fabs(a[i]))) << a[i];
        ASSERT_FALSE(std::signbit(result[i])) << a[i];
      }
    });
}

TEST_P(FloatN, LowestAndHighestLaneAreThoseOfAllLanes) {
  for (const Lanes& lanes : instructions(GetParam()).lanes)
    for (int at = 0; at < lanes.width; ++at) {
      float a[16];
      for (int i = 0; i < lanes.width; ++i) a[i] = float(i % 5);
      a[at] = -1.0f;
      EXPECT_EQ(lanes.lowest_lane(a), -1.0f) << at;
      a[at] = 9.0f;
      EXPECT_EQ(lanes.highest_lane(a), 9.0f) << at;
    }
}

TEST_P(FloatN, GatherTransposesFourPointsAndReadsNothingBeyond) {
  // Allocated to the byte, so that the address sanitizer sees a read too far.
  const std::vector<float> points{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const std::uint32_t index[4] = {3, 0, 2, 3};
  float r[3][4];
  instructions(GetParam()).gather_points(points.data(), index, r);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 4; ++i) EXPECT_EQ(r[k][i], points[3 * index[i] + std::uint32_t(k)]);
}

TEST_P(FloatN, ALoadedPointHasAZeroInItsSpareLane) {
  const std::vector<float> point{1, -2, 3};
  float r[4] = {9, 9, 9, 9};
  instructions(GetParam()).load_point(point.data(), r);
  EXPECT_EQ(r[0], 1.0f);
  EXPECT_EQ(r[1], -2.0f);
  EXPECT_EQ(r[2], 3.0f);
  EXPECT_EQ(r[3], 0.0f);
}

}  // namespace
}  // namespace regraft::test
