#include "regraft/accel/mending_budget.h"

#include <gtest/gtest.h>

namespace regraft::test {
namespace {

TEST(MendingBudget, IsLessThanHalfOfWhatFollowingTheMotionCosts) {
  accel::MendingBudget budget;
  budget.note_refit(200'000);
  const double first = budget.tests();
  EXPECT_GT(first, 200'000.0);
  EXPECT_LT(first, 0.5 * 6.0 * 200'000.0);
  budget.note_refit(400'000);
  EXPECT_GT(budget.tests(), first);
  EXPECT_LT(budget.tests(), 2.0 * first);
}

TEST(MendingBudget, OneLargeFrameIsForgottenAtOnce) {
  accel::MendingBudget budget, small;
  budget.note_refit(1'000'000);
  for (accel::MendingBudget* b : {&budget, &small}) b->note_refit(50'000);
  EXPECT_EQ(budget.tests(), small.tests());
}

TEST(MendingBudget, SomethingCanAlwaysBeDone) {
  accel::MendingBudget budget;
  budget.note_refit(3);
  EXPECT_GT(budget.tests(), 10'000.0);
  EXPECT_GE(budget.looks(1e9), 64u);
}

}  // namespace
}  // namespace regraft::test
