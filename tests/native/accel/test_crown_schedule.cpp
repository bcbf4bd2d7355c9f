#include "regraft/accel/crown_schedule.h"

#include <gtest/gtest.h>

namespace regraft::test {
namespace {

/// In how many of 200 updates the top is tried, where each try saves `saved` tests a frame.
int tries(double saved, double price) {
  accel::CrownSchedule schedule;
  int count = 0;
  for (int update = 0; update < 200; ++update) {
    if (!schedule.is_due(1000.0, price)) continue;
    ++count;
    schedule.note(saved, price);
  }
  return count;
}

TEST(CrownSchedule, WhatPaysIsTriedAlwaysAndWhatDoesNotHardlyEver) {
  EXPECT_GT(tries(500.0, 10.0), 190);
  EXPECT_LT(tries(0.0, 10.0), 10);
  EXPECT_GT(tries(0.0, 10.0), 3) << "things may have changed";
}

TEST(CrownSchedule, NothingIsTriedThatCouldNotPay) {
  accel::CrownSchedule schedule;
  for (int update = 0; update < 9; ++update) EXPECT_FALSE(schedule.is_due(10.0, 100.0));
  schedule.is_due(10.0, 100.0);
  EXPECT_TRUE(schedule.is_due(10.0, 100.0)) << "in eleven frames it could";
}

}  // namespace
}  // namespace regraft::test
