#include "regraft/accel/update_policy.h"

#include <gtest/gtest.h>

namespace regraft::test {
namespace {

using accel::Habit;
using accel::TreeUpdate;

/// In how many of 200 frames a tree is measured in which a frame loses `lost` tests that looking
/// brings back.
int looks(double lost, double price) {
  Habit habit;
  double damage = 0.0;
  int count = 0;
  for (int frame = 0; frame < 200; ++frame) {
    damage += lost;
    const bool measures = habit.measures();
    habit.note(TreeUpdate::refit, measures ? accel::Look{price, damage} : accel::Look{});
    if (!measures) continue;
    damage = 0.0;
    ++count;
  }
  return count;
}

TEST(Habit, TreesAreMeasuredAsOftenAsTheirDamagePaysForIt) {
  EXPECT_EQ(looks(1000.0, 100.0), 200);
  EXPECT_LT(looks(0.0, 100.0), 20);
  EXPECT_GT(looks(0.0, 100.0), 10);
  const int some = looks(10.0, 100.0);
  EXPECT_GT(some, 30);
  EXPECT_LT(some, 120);
}

TEST(Habit, AnAlarmedTreeIsMeasuredAtOnce) {
  Habit habit;
  for (int frame = 0; frame < 40; ++frame) habit.note(TreeUpdate::refit, {1.0, 0.0});
  while (habit.measures()) habit.note(TreeUpdate::refit, {1.0, 0.0});
  habit.alarm();
  EXPECT_TRUE(habit.measures());
  habit.note(TreeUpdate::refit, {1.0, 0.0});
  EXPECT_FALSE(habit.measures());
}

TEST(ChooseUpdate, WhatRaysLostIsHeededByThosePoliciesThatMend) {
  accel::TreeState tree;
  tree.exists = tree.moved = tree.refitted = true;
  for (const bool overpaid : {false, true}) {
    tree.overpaid = overpaid;
    for (const accel::Policy policy :
         {accel::Policy::automatic, accel::Policy::selective, accel::Policy::selective_rotate})
      EXPECT_EQ(choose_update(tree, policy) == TreeUpdate::rebuild, overpaid) << name(policy);
    EXPECT_EQ(choose_update(tree, accel::Policy::refit), TreeUpdate::refit);
  }
}

}  // namespace
}  // namespace regraft::test
