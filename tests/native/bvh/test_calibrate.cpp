#include "regraft/bvh/calibrate.h"

#include <gtest/gtest.h>

#include <chrono>

#include "bvh/boxes.h"

namespace regraft::test {
namespace {

/// A probe of `count` operations that together take `us` microseconds.
std::function<std::size_t()> waits(double us, std::size_t count) {
  return [us, count] {
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
               .count() < us)
      continue;
    return count;
  };
}

TEST(Calibrate, ConstantsAreTimesInBoxTests) {
  const bvh::MachineConstants found =
      bvh::calibrate({waits(200, 100), waits(600, 100), waits(1000, 50)}, pool(1));
  // 2, 6 and 20 microseconds each; a busy machine only ever adds.
  EXPECT_NEAR(found.leaf, 3.0, 1.0);
  EXPECT_NEAR(found.refine, 10.0, 4.0);
  EXPECT_GT(found.rebuild, 0.0);
}

TEST(Calibrate, WithoutPairsTheirCostIsTheDefault) {
  const bvh::MachineConstants found = bvh::calibrate({waits(50, 1), waits(50, 1), {}}, pool(1));
  EXPECT_EQ(found.refine, bvh::MachineConstants{}.refine);
}

TEST(Calibrate, OurOwnProbesTakeTimeAndSayHowOften) {
  const bvh::Probes probes = bvh::test_probes();
  EXPECT_EQ(probes.box_tests(), probes.triangle_tests());
  EXPECT_GT(probes.box_tests(), 1000u);
}

}  // namespace
}  // namespace regraft::test
