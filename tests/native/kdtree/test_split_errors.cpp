#include "regraft/kdtree/split_errors.h"

#include <gtest/gtest.h>

#include <limits>

#include "kdtree/stand.h"

namespace regraft::test {
namespace {

using kdtree::ScanConfig;
using kdtree::SplitErrors;

constexpr double never = std::numeric_limits<double>::infinity();

std::vector<SplitErrors> errors_of(std::span<const ScanConfig> scans) {
  Stand stand;
  stand.add(soup(3000, 7, 10.0, 0.5));
  return kdtree::split_errors(stand.hierarchy(), {}, scans);
}

TEST(SplitErrors, StayBelowWhatTheScansProve) {
  const ScanConfig scans[] = {{.epsilon = never, .samples = 1},
                              {.epsilon = never, .samples = 15},
                              {.epsilon = 0.3},
                              {.epsilon = 0.01}};
  for (const SplitErrors& e : errors_of(scans)) {
    EXPECT_GT(e.nodes, 100u);
    EXPECT_GE(e.worst_excess, e.mean_excess);
    EXPECT_LE(e.mean_excess, e.mean_certificate);
    EXPECT_LE(e.worst_excess, e.worst_certificate);
    EXPECT_GT(e.mean_samples, 0.0);
  }
}

TEST(SplitErrors, ShrinkWithMorePlanesAndSmallerBounds) {
  const ScanConfig scans[] = {{.epsilon = never, .samples = 1},
                              {.epsilon = never, .samples = 63},
                              {.epsilon = 0.03},
                              {.epsilon = 0.0}};
  const auto errors = errors_of(scans);
  EXPECT_GT(errors[0].mean_excess, errors[1].mean_excess);
  EXPECT_GT(errors[0].worst_excess, 0.03);
  EXPECT_LE(errors[2].worst_excess, 0.03);
  EXPECT_NEAR(errors[3].worst_excess, 0.0, 1e-12);
}

TEST(SplitErrors, AreNoneWhereEntriesAreSorted) {
  const ScanConfig sorts[] = {{.exact_below = 1'000'000}};
  EXPECT_EQ(errors_of(sorts)[0].nodes, 0u);
}

}  // namespace
}  // namespace regraft::test
