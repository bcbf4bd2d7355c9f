#include "oracle.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace regraft::test {
namespace {

/// 128 bits; no standard type.
__extension__ typedef __int128 Wide;

const ExactTriangle unit{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
const Vec3d down(0, 0, -1);

Verdict look(double x, double y) {
  return judge({x, y, 5}, down, unit).verdict;
}

TEST(Oracle, ExpansionsKeepWhatADoubleLoses) {
  const Expansion big = Expansion(1e200) + Expansion(1.0);
  EXPECT_EQ((big + Expansion(-1e200)).sign(), 1);
  EXPECT_EQ((big + Expansion(-1e200) + Expansion(-1.0)).sign(), 0);
  EXPECT_EQ((big.negated() + Expansion(1e200)).sign(), -1);
  EXPECT_EQ(Expansion(0.0).sign(), 0);
}

TEST(Oracle, ExpansionsMultiplyExactly) {
  const double x = 1.0 + 0x1p-52;
  // x² = 1 + 2^-51 + 2^-104
  const Expansion square = Expansion(x) * Expansion(x);
  const Expansion rounded = Expansion(1.0 + 0x1p-51);
  EXPECT_EQ((square + rounded.negated()).sign(), 1);
  EXPECT_EQ((square + rounded.negated() + Expansion(-0x1p-104)).sign(), 0);
}

RC_GTEST_PROP(Oracle, ExpansionsAgreeWithIntegersOf128Bits, ()) {
  const auto part = rc::gen::inRange<std::int64_t>(-(1LL << 53), 1LL << 53);
  const std::int64_t a = *part, b = *part, c = *part;
  const std::int64_t d = *rc::gen::element(*part, c, -c);
  const Wide exact = Wide(a) * b - Wide(c) * d;
  const Expansion e = Expansion(double(a)) * Expansion(double(b)) +
                      (Expansion(double(c)) * Expansion(double(d))).negated();
  RC_ASSERT(e.sign() == (exact > 0 ? 1 : exact < 0 ? -1 : 0));
}

TEST(Oracle, SaysHitMissAndBoundary) {
  EXPECT_EQ(look(0.25, 0.25), Verdict::hit);
  EXPECT_EQ(look(0.75, 0.75), Verdict::miss);
  EXPECT_EQ(look(-0.25, 0.25), Verdict::miss);
  EXPECT_EQ(look(0.5, 0.5), Verdict::boundary);
  EXPECT_EQ(look(0, 0.5), Verdict::boundary);
  EXPECT_EQ(look(0, 0), Verdict::boundary);
  EXPECT_EQ(look(1, 0), Verdict::boundary);
  EXPECT_EQ(look(0, 1.5), Verdict::miss);
}

TEST(Oracle, TheSideOfTheNearestDoubleIsStillTold) {
  const double next = std::nextafter(0.5, 1.0), last = std::nextafter(0.5, 0.0);
  EXPECT_EQ(look(next, 0.5), Verdict::miss);
  EXPECT_EQ(look(last, 0.5), Verdict::hit);
  EXPECT_EQ(look(next, last), look(last, next));
  EXPECT_EQ(look(1e-300, 0.5), Verdict::hit);
  EXPECT_EQ(look(-1e-100, 0.5), Verdict::miss);
}

TEST(Oracle, WindingAndTheLinesDirectionDoNotMatter) {
  const ExactTriangle flipped{unit.a, unit.c, unit.b};
  EXPECT_EQ(judge({0.25, 0.25, 5}, down, flipped).verdict, Verdict::hit);
  EXPECT_EQ(judge({0.25, 0.25, -5}, {0, 0, 1e-30}, unit).verdict, Verdict::hit);
  EXPECT_EQ(judge({0.25, 0.25, 5}, {0, 0, 1e30}, flipped).verdict, Verdict::hit);
}

TEST(Oracle, ATriangleSeenEdgeOnIsMissed) {
  EXPECT_EQ(judge({-1, 0.25, 0}, {1, 0, 0}, unit).verdict, Verdict::miss);
  const ExactTriangle flat{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
  EXPECT_EQ(judge({1, 1, 5}, down, flat).verdict, Verdict::miss);
}

TEST(Oracle, TIsInUnitsOfTheDirectionAndTheMarginIsAcrossIt) {
  const Judgement j = judge({0.25, 0.125, 5}, {0, 0, -2}, unit);
  EXPECT_EQ(j.t, Real(2.5));
  EXPECT_EQ(j.margin, Real(0.125));
  EXPECT_EQ(j.cosine, Real(1));
  EXPECT_LT(judge({0.25, 0.25, 0}, {0, 0, 1}, unit).t, 1e-30L);
  const Judgement outside = judge({-3, -4, 5}, down, unit);
  EXPECT_EQ(outside.margin, Real(5));
}

TEST(Oracle, CosineIsThatOfTheAngleToTheNormal) {
  EXPECT_NEAR(double(judge({0, 0.25, 5}, {1, 0, -1}, unit).cosine), std::sqrt(0.5), 1e-15);
  EXPECT_EQ(judge({0, 0.25, 5}, {1, 0, 0}, unit).cosine, Real(0));
}

TEST(Oracle, DistanceIsToTheInsideTheEdgesAndTheCorners) {
  EXPECT_EQ(distance({0.25, 0.25, -3}, unit), Real(3));
  EXPECT_EQ(distance({0.25, 0.25, 0}, unit), Real(0));
  EXPECT_EQ(distance({0.5, -2, 0}, unit), Real(2));
  EXPECT_EQ(distance({-3, -4, 0}, unit), Real(5));
  EXPECT_NEAR(double(distance({1, 1, 0}, unit)), std::sqrt(0.5), 1e-15);
  EXPECT_EQ(distance({0, 4, 3}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), Real(5));
  EXPECT_EQ(distance({0, 4, 3}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}), Real(5));
}

RC_GTEST_PROP(Oracle, AgreesWithIntegerArithmetic, ()) {
  const auto point = [] {
    const auto part = rc::gen::inRange(-4, 5);
    return std::array<int, 3>{*part, *part, *part};
  };
  const auto o = point(), d = point(), a = point(), b = point();
  const auto at = [](const auto& p) { return Vec3d(p[0], p[1], p[2]); };
  const auto minor = [&](int i, int j) {
    return (a[i] - o[i]) * (b[j] - o[j]) - (a[j] - o[j]) * (b[i] - o[i]);
  };
  const int det = d[0] * minor(1, 2) + d[1] * minor(2, 0) + d[2] * minor(0, 1);
  RC_CLASSIFY(det == 0);
  RC_ASSERT(side_of(at(o), at(d), at(a), at(b)) == (det > 0 ? 1 : det < 0 ? -1 : 0));
}

}  // namespace
}  // namespace regraft::test
