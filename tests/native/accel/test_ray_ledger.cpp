#include "regraft/accel/ray_ledger.h"

#include <gtest/gtest.h>

namespace regraft::test {
namespace {

/// Builds in 400 frames in which rays do ever more work, until a build; `brought_back`: the share
/// of what was lost that a build brings back.
int builds(double brought_back) {
  accel::RayLedger ledger;
  double kept = 0.0, lost = 0.0;
  int count = 0;
  for (int frame = 0; frame < 400; ++frame) {
    ledger.note(1000.0 + kept + lost);
    if (ledger.lost_tests() > 1e5) {
      ledger.begin();
      kept += (1.0 - brought_back) * lost;
      lost = 0.0;
      ++count;
    }
    lost += 100.0;
  }
  return count;
}

TEST(RayLedger, BuildsAreDueWhereTheyBringBackWhatWasLost) {
  EXPECT_GT(builds(1.0), 20);
}

TEST(RayLedger, BuildsThatBringNothingBecomeRare) {
  EXPECT_GT(builds(0.0), 0);
  EXPECT_LT(builds(0.0), builds(1.0) / 2);
}

TEST(RayLedger, WithoutLossOrRaysNothingIsDue) {
  accel::RayLedger ledger;
  for (const double work : {0.0, 500.0, 500.0, 0.0, 300.0, 500.0}) ledger.note(work);
  EXPECT_EQ(ledger.lost_tests(), 0.0);
}

}  // namespace
}  // namespace regraft::test
