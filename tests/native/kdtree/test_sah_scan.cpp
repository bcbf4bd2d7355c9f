#include "regraft/kdtree/sah_scan.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <random>

#include "kdtree/split_cases.h"
#include "regraft/kdtree/sah_count.h"

namespace regraft::test {
namespace {

using kdtree::ChildProbability;
using kdtree::OriginMetric;
using kdtree::SahScan;
using kdtree::SahSweep;
using kdtree::ScanConfig;
using kdtree::Split;
using kdtree::SplitCost;
using kdtree::SplitEntry;

constexpr double never = std::numeric_limits<double>::infinity();

/// Without the short cut for few entries.
ScanConfig scan(double epsilon, int samples = 15) {
  return {.epsilon = epsilon, .samples = samples, .exact_below = 0};
}

SplitCase any_case(std::uint32_t seed) {
  const std::size_t counts[] = {8, 9, 20, 63, 64, 65, 200, 1023, 1024, 3000};
  return split_case(int(seed % split_case_kinds), counts[seed / 8 % std::size(counts)], seed);
}

ChildProbability any_probability(const SplitCase& c, std::uint32_t seed) {
  const Aabb origins{Vec3(-3, 0, -1), Vec3(12, 11, 10)};
  if (seed % 3 == 0) return ChildProbability(c.voxel);
  // The exact form takes microseconds a plane.
  const bool exact = seed % 3 == 1 && c.entries.size() < 100;
  return ChildProbability(c.voxel, exact ? OriginMetric::exact : OriginMetric::regions6, origins);
}

RC_GTEST_PROP(SahScan, BoundsTheExactSplitFromBothSides, (std::uint32_t seed)) {
  const SplitCase c = any_case(seed);
  const ChildProbability probability = any_probability(c, seed / 100);
  const Split exact = SahSweep(never_cut_empty).find(c.entries, probability);
  for (const int samples : {1, 3, 15, 63}) {
    const Split split = SahScan(never_cut_empty, scan(never, samples)).find(c.entries, probability);
    RC_ASSERT(split.lower_bound <= exact.cost);
    RC_ASSERT(exact.cost <= split.cost * (1 + 1e-15));
    if (!split.found()) continue;
    const double counted =
        brute_force_cost(c, probability, never_cut_empty, split.axis, split.position);
    RC_ASSERT(split.cost == counted);
  }
}

RC_GTEST_PROP(SahScan, IsWithinEpsilonOfTheExactSplit, (std::uint32_t seed)) {
  const SplitCase c = any_case(seed);
  const ChildProbability probability = any_probability(c, seed / 100);
  const double leaf = 1.5 * kdtree::summarise(c.entries).weight;
  const Split exact = SahSweep(never_cut_empty).find(c.entries, probability);
  for (const double epsilon : {0.3, 0.03, 1e-3}) {
    const Split split = SahScan(never_cut_empty, scan(epsilon)).find(c.entries, probability);
    RC_ASSERT(split.lower_bound <= exact.cost);
    // A leaf that nothing beats is found to be one, and no more is.
    RC_ASSERT(std::min(split.cost, leaf) <= (1 + epsilon) * std::min(exact.cost, leaf));
    RC_ASSERT((!split.found() || exact.found()));
    if (split.found()) RC_ASSERT(split.certificate() <= epsilon * (1 + 1e-12));
  }
}

RC_GTEST_PROP(SahScan, WithoutErrorIsTheSortedSweep, (std::uint32_t seed)) {
  const SplitCase c = any_case(seed);
  const ChildProbability probability = any_probability(c, seed / 100);
  const Split exact = SahSweep(never_cut_empty).find(c.entries, probability);
  const Split split = SahScan(never_cut_empty, scan(0.0)).find(c.entries, probability);
  RC_ASSERT(split.found() == exact.found());
  if (!exact.found()) return;
  RC_ASSERT(std::abs(split.cost - exact.cost) <= 1e-12 * exact.cost);
  RC_ASSERT(split.lower_bound == split.cost);
}

RC_GTEST_PROP(SahScan, IsNeverWorseWithMoreSamples, (std::uint32_t seed)) {
  const SplitCase c = any_case(seed);
  const ChildProbability probability = any_probability(c, seed / 100);
  Split last = SahScan(never_cut_empty, scan(never, 1)).find(c.entries, probability);
  for (const int samples : {3, 7, 15, 31, 63}) {
    const Split split = SahScan(never_cut_empty, scan(never, samples)).find(c.entries, probability);
    RC_ASSERT(split.cost <= last.cost);
    RC_ASSERT(split.lower_bound >= last.lower_bound * (1 - 1e-12));
    last = split;
  }
}

RC_GTEST_PROP(SahScan, DoesNotDependOnTheOrderOfEntries, (std::uint32_t seed)) {
  SplitCase c = any_case(seed);
  const ChildProbability probability = any_probability(c, seed / 100);
  std::mt19937 random(seed);
  for (const double epsilon : {never, 0.1, 0.0}) {
    const Split split = SahScan({}, scan(epsilon)).find(c.entries, probability);
    std::shuffle(c.entries.begin(), c.entries.end(), random);
    const Split other = SahScan({}, scan(epsilon)).find(c.entries, probability);
    RC_ASSERT(split.axis == other.axis);
    RC_ASSERT(split.position == other.position);
    RC_ASSERT(split.cost == other.cost);
    RC_ASSERT(split.lower_bound == other.lower_bound);
  }
}

TEST(SahScan, OfFewEntriesIsExactWhateverIsAsked) {
  for (int kind = 0; kind < split_case_kinds; ++kind)
    for (const std::size_t count : {1u, 2u, 7u, 15u, 16u}) {
      const SplitCase c = split_case(kind, count, 3);
      const ChildProbability probability(c.voxel);
      const Split exact = SahSweep().find(c.entries, probability);
      const Split split = SahScan().find(c.entries, probability);
      EXPECT_EQ(split.axis, exact.axis) << kind << " " << count;
      if (exact.found()) {
        EXPECT_EQ(split.cost, exact.cost) << kind << " " << count;
      }
    }
}

TEST(SahScan, CountingFindsWhatSortingFinds) {
  int counted = 0;
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    const SplitCase c = split_case(int(seed % split_case_kinds), 1 + seed % 64, seed);
    if (!kdtree::countable(c.entries)) continue;
    ++counted;
    const ChildProbability probability = any_probability(c, 3 * (seed % 7));
    const Split sorted = SahSweep(never_cut_empty).find(c.entries, probability);
    const Split found = kdtree::count_split(c.entries, probability, never_cut_empty);
    EXPECT_EQ(found.cost, sorted.cost) << seed;
    if (!sorted.found()) continue;
    EXPECT_EQ(found.axis, sorted.axis) << seed;
    EXPECT_EQ(found.position, sorted.position) << seed;
    EXPECT_EQ(found.flat_left, sorted.flat_left) << seed;
  }
  EXPECT_GT(counted, 100);
}

TEST(SahScan, OnlyWholeWeightsThatAFloatCanSumAreCounted) {
  std::vector<SplitEntry> entries(3, {{Vec3(0), Vec3(1)}});
  EXPECT_TRUE(kdtree::countable(entries));
  entries[0].weight = 0.5;
  EXPECT_FALSE(kdtree::countable(entries));
  entries[0].weight = 0x1p53;
  EXPECT_FALSE(kdtree::countable(entries));
  entries[0].weight = 0x1p24 - 2.0;
  EXPECT_TRUE(kdtree::countable(entries));
  entries[1].weight = 2.0;
  EXPECT_FALSE(kdtree::countable(entries));
}

TEST(SahScan, FindsThePlaneWhereTwoHalvesOfAGridAbut) {
  std::vector<SplitEntry> entries;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z) entries.push_back({{Vec3(x, y, z), Vec3(x + 1, y + 1, z + 1)}});
  const ChildProbability probability({Vec3(0), Vec3(4)});
  for (const double epsilon : {never, 0.1, 0.0}) {
    const Split split = SahScan({}, scan(epsilon)).find(entries, probability);
    EXPECT_EQ(split.axis, 0);
    EXPECT_EQ(split.position, 2.0f);
    EXPECT_EQ(split.cost, 1.0 + 1.5 * 2.0 * 32.0 * (64.0 / 96.0));
  }
}

TEST(SahScan, FindsTheTeapotInTheStadium) {
  const SplitCase c = split_case(4, 5000, 1);
  const ChildProbability probability(c.voxel);
  const Split exact = SahSweep(never_cut_empty).find(c.entries, probability);
  const Split refined = SahScan(never_cut_empty, scan(0.01)).find(c.entries, probability);
  EXPECT_LE(refined.cost, 1.01 * exact.cost);
  EXPECT_LT(refined.samples, 4000u) << "of 30,000 bounds";
  const Split scanned = SahScan(never_cut_empty, scan(never)).find(c.entries, probability);
  EXPECT_LT(scanned.cost, 1.2 * exact.cost);
  EXPECT_GT(scanned.certificate(), 0.2) << "two passes prove little here";
}

/// Both searches, so that what holds for one holds for the other.
void expect_no_split(const std::vector<SplitEntry>& entries, const Aabb& voxel) {
  const ChildProbability probability(voxel);
  EXPECT_FALSE(SahSweep().find(entries, probability).found());
  for (const double epsilon : {never, 0.1, 0.0})
    EXPECT_FALSE(SahScan({}, scan(epsilon)).find(entries, probability).found());
}

TEST(SahScan, DoesNotSplitWhatAPlaneCannotPart) {
  const Aabb voxel{Vec3(0), Vec3(10)};
  expect_no_split(std::vector<SplitEntry>(100, {voxel}), voxel);
  expect_no_split(std::vector<SplitEntry>(100, {{Vec3(0, 0, 0), Vec3(10, 10, 0)}}), voxel);
  expect_no_split(std::vector<SplitEntry>(100, {{Vec3(1), Vec3(2)}, 0.0}), voxel);
  expect_no_split({}, voxel);
  expect_no_split(std::vector<SplitEntry>(100, {{Vec3(1), Vec3(1)}}), {Vec3(1), Vec3(1)});
}

TEST(SahScan, CutsTheSpaceRoundEqualEntriesThenStops) {
  const std::vector<SplitEntry> equal(100, {{Vec3(2), Vec3(3)}, 1.0});
  const Split split = SahScan({}, scan(never)).find(equal, ChildProbability({Vec3(0), Vec3(10)}));
  EXPECT_EQ(split.position, 3.0f);
  EXPECT_TRUE(split.flat_left);
  expect_no_split(equal, {Vec3(2), Vec3(3)});
}

TEST(SahScan, IgnoresEntriesWithoutWeight) {
  SplitCase c = split_case(0, 300, 9);
  const ChildProbability probability(c.voxel);
  const Split without = SahScan({}, scan(0.0)).find(c.entries, probability);
  for (int i = 0; i < 200; ++i) c.entries.push_back({{Vec3(0.01f * float(i)), Vec3(5)}, 0.0});
  for (const double epsilon : {0.0, 0.1}) {
    const Split with = SahScan({}, scan(epsilon)).find(c.entries, probability);
    EXPECT_LE(with.cost, (1 + epsilon) * without.cost);
  }
  EXPECT_EQ(SahSweep().find(c.entries, probability).cost, without.cost);
}

TEST(SahScan, TakesWeightsAtTheEndOfWholeNumbers) {
  SplitCase c = split_case(0, 300, 2);
  for (std::size_t i = 0; i < c.entries.size(); i += 3) c.entries[i].weight = 9007199254740992.0;
  const ChildProbability probability(c.voxel);
  const Split exact = SahSweep().find(c.entries, probability);
  const Split split = SahScan({}, scan(0.0)).find(c.entries, probability);
  EXPECT_TRUE(split.found());
  EXPECT_NEAR(split.cost / exact.cost, 1.0, 1e-12);
}

TEST(SahScan, TakesVoxelsOfAnySizeAndPlanesOneStepFromAFace) {
  for (const float size : {1e-38f, 1e-30f, 1e-6f, 1e12f, 1e30f, 1.5e38f}) {
    SplitCase c = split_case(1, 300, 4);
    for (SplitEntry& entry : c.entries) {
      entry.box.lo *= 0.1f * size;
      entry.box.hi *= 0.1f * size;
    }
    const ChildProbability probability({Vec3(0), Vec3(size)});
    const Split exact = SahSweep().find(c.entries, probability);
    for (const double epsilon : {never, 0.01}) {
      const Split split = SahScan({}, scan(epsilon)).find(c.entries, probability);
      EXPECT_TRUE(split.found()) << size;
      EXPECT_LT(split.cost, 1.1 * exact.cost) << size;
    }
  }
  const float step = std::nextafter(0.0f, 1.0f);
  std::vector<SplitEntry> entries(40, {{Vec3(0), Vec3(step, 10, 10)}});
  entries.resize(80, {{Vec3(step, 0, 0), Vec3(10)}});
  const ChildProbability probability({Vec3(0), Vec3(10)});
  for (const double epsilon : {never, 0.0}) {
    const Split split = SahScan({}, scan(epsilon)).find(entries, probability);
    EXPECT_EQ(split.axis, 0);
    EXPECT_EQ(split.position, step);
  }
}

TEST(SahScan, PutsAFloorInAPlaneToOneSide) {
  // A grid of flat tiles at the height of a plane of the scene, and boxes on it.
  std::vector<SplitEntry> entries;
  for (int i = 0; i < 100; ++i) {
    const float x = float(i % 10);
    const float y = float(i / 10);
    entries.push_back({{Vec3(x, y, 4), Vec3(x + 1, y + 1, 4)}});
    entries.push_back({{Vec3(x, y, 4), Vec3(x + 1, y + 1, 4.5f)}});
  }
  const Aabb voxel{Vec3(0, 0, 3), Vec3(10, 10, 5)};
  const ChildProbability probability(voxel);
  const Split split = SahScan({}, scan(never)).find(entries, probability);
  EXPECT_EQ(split.axis, 2);
  EXPECT_EQ(split.position, 4.0f);
  EXPECT_FALSE(split.flat_left) << "with the boxes, away from the empty side";
}

}  // namespace
}  // namespace regraft::test
