#include "regraft/kdtree/sah_sweep.h"

#include <gtest/gtest.h>

#include "kdtree/split_cases.h"

namespace regraft::test {
namespace {

using kdtree::ChildProbability;
using kdtree::OriginMetric;
using kdtree::SahSweep;
using kdtree::Split;
using kdtree::SplitCost;
using kdtree::SplitEntry;

TEST(SahSweep, FindsThePlaneThatCountingForEveryPlaneFinds) {
  for (int kind = 0; kind < split_case_kinds; ++kind)
    for (const std::size_t count : {1u, 2u, 5u, 40u, 150u}) {
      const SplitCase c = split_case(kind, count, std::uint32_t(7 * count) + 1);
      const ChildProbability probability(c.voxel);
      const Split expected = brute_force_split(c, probability, never_cut_empty);
      const Split split = SahSweep(never_cut_empty).find(c.entries, probability);
      EXPECT_EQ(split.axis, expected.axis) << kind << " " << count;
      EXPECT_EQ(split.position, expected.position) << kind << " " << count;
      EXPECT_EQ(split.cost, expected.cost) << kind << " " << count;
      EXPECT_EQ(split.flat_left, expected.flat_left);
      EXPECT_EQ(split.certificate(), 0.0);
    }
}

TEST(SahSweep, FindsTheGapBetweenTwoClusters) {
  std::vector<SplitEntry> entries;
  for (int i = 0; i < 10; ++i) {
    entries.push_back({{Vec3(0), Vec3(10, 10, 2)}});
    entries.push_back({{Vec3(0, 0, 8), Vec3(10)}});
  }
  const Split split =
      SahSweep(never_cut_empty).find(entries, ChildProbability({Vec3(0), Vec3(10)}));
  EXPECT_EQ(split.axis, 2);
  EXPECT_EQ(split.position, 2.0f);
  EXPECT_NEAR(split.cost, 1.0 + 1.5 * 10 * (140.0 / 300.0 + 260.0 / 300.0), 1e-12);
}

TEST(SahSweep, TakesAPlaneThatCutsOffAThirdOfEmptySpaceBeforeABetterOne) {
  std::vector<SplitEntry> entries;
  for (int i = 0; i < 10; ++i) {
    entries.push_back({{Vec3(3.5f, 0, 0), Vec3(10, 10, 1)}});
    entries.push_back({{Vec3(3.5f, 0, 9), Vec3(10)}});
  }
  const ChildProbability probability({Vec3(0), Vec3(10)});
  const Split split = SahSweep().find(entries, probability);
  EXPECT_EQ(split.axis, 0);
  EXPECT_EQ(split.position, 3.5f);
  EXPECT_FALSE(split.flat_left);
  EXPECT_EQ(SahSweep(never_cut_empty).find(entries, probability).axis, 2);
  EXPECT_EQ(SahSweep({.empty_cut = 0.36}).find(entries, probability).axis, 2);
}

TEST(SahSweep, LeavesOneTriangleInALargeVoxelAlone) {
  const std::vector<SplitEntry> one{{{Vec3(4), Vec3(5)}}};
  EXPECT_FALSE(
      SahSweep({.traverse = 10.0}).find(one, ChildProbability({Vec3(0), Vec3(10)})).found());
}

}  // namespace
}  // namespace regraft::test
