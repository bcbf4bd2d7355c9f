#include "regraft/scene/change_log.h"

#include <gtest/gtest.h>

#include <vector>

namespace regraft {
namespace {

using Ids = std::vector<std::uint32_t>;

TEST(ChangeLog, BeginsEmpty) {
  EXPECT_TRUE(ChangeLog().changes().empty());
}

TEST(ChangeLog, TakingHandsOverAndStartsAnew) {
  ChangeLog log;
  log.mesh_added(0);
  log.instance_added(0, true);
  EXPECT_EQ(log.changes().added_meshes, Ids{0});
  EXPECT_EQ(log.take().added_meshes, Ids{0});
  EXPECT_TRUE(log.take().empty());
}

TEST(ChangeLog, AMeshAddedThenChangedStaysAdded) {
  ChangeLog log;
  log.mesh_added(0);
  log.mesh_deformed(0);
  log.mesh_retopologised(0);
  const ChangeSet set = log.take();
  EXPECT_EQ(set.added_meshes, Ids{0});
  EXPECT_TRUE(set.deformed_meshes.empty());
  EXPECT_TRUE(set.retopologised_meshes.empty());
}

TEST(ChangeLog, RetopologisedWinsOverDeformedInEitherOrder) {
  ChangeLog log;
  log.mesh_deformed(3);
  log.mesh_retopologised(3);
  log.mesh_retopologised(1);
  log.mesh_deformed(1);
  log.mesh_deformed(2);
  log.mesh_deformed(2);
  const ChangeSet set = log.take();
  EXPECT_EQ(set.retopologised_meshes, (Ids{3, 1}));
  EXPECT_EQ(set.deformed_meshes, Ids{2});
}

TEST(ChangeLog, ARemovedMeshIsOnlyRemoved) {
  ChangeLog log;
  log.mesh_deformed(0);
  log.mesh_removed(0);
  const ChangeSet set = log.take();
  EXPECT_EQ(set.removed_meshes, Ids{0});
  EXPECT_TRUE(set.deformed_meshes.empty());
}

TEST(ChangeLog, AMeshAddedAndRemovedUnseenIsNoChange) {
  ChangeLog log;
  log.mesh_added(0);
  log.mesh_deformed(0);
  log.mesh_removed(0);
  EXPECT_TRUE(log.changes().empty());
  log.take();
  log.mesh_added(1);
  EXPECT_EQ(log.take().added_meshes, Ids{1});
}

/// One instance that has been seen.
ChangeLog seen_instance() {
  ChangeLog log;
  log.instance_added(0, true);
  log.take();
  return log;
}

TEST(ChangeLog, MovesOfAnInstanceAreToldOnce) {
  ChangeLog log = seen_instance();
  log.instance_moved(0);
  log.instance_moved(0);
  const ChangeSet set = log.take();
  EXPECT_EQ(set.moved_instances, Ids{0});
  EXPECT_FALSE(set.instance_set_changed);
  EXPECT_TRUE(log.take().empty());
}

TEST(ChangeLog, TheMoveOfANewInstanceIsNotTold) {
  ChangeLog log;
  log.instance_added(0, true);
  log.instance_moved(0);
  const ChangeSet set = log.take();
  EXPECT_TRUE(set.moved_instances.empty());
  EXPECT_TRUE(set.instance_set_changed);
}

TEST(ChangeLog, TheMoveOfAHiddenInstanceIsToldWhenItIsShown) {
  ChangeLog log = seen_instance();
  log.instance_shown(0, false);
  EXPECT_TRUE(log.take().instance_set_changed);
  log.instance_moved(0);
  EXPECT_TRUE(log.changes().empty());
  log.take();
  log.instance_shown(0, true);
  const ChangeSet set = log.take();
  EXPECT_TRUE(set.instance_set_changed);
  EXPECT_EQ(set.moved_instances, Ids{0});
}

TEST(ChangeLog, AMoveBeforeHidingIsToldWhenShownAgain) {
  ChangeLog log = seen_instance();
  log.instance_moved(0);
  log.instance_shown(0, false);
  EXPECT_TRUE(log.take().moved_instances.empty());
  log.instance_shown(0, true);
  EXPECT_EQ(log.take().moved_instances, Ids{0});
  log.instance_shown(0, false);
  log.instance_shown(0, true);
  EXPECT_TRUE(log.take().moved_instances.empty());
}

TEST(ChangeLog, MovedHiddenAndShownBetweenTwoUpdatesIsToldOnce) {
  ChangeLog log = seen_instance();
  log.instance_moved(0);
  log.instance_shown(0, false);
  log.instance_moved(0);
  log.instance_shown(0, true);
  log.instance_moved(0);
  EXPECT_EQ(log.take().moved_instances, Ids{0});
}

TEST(ChangeLog, AnInstanceAddedHiddenIsNoChangeUntilItIsShown) {
  ChangeLog log;
  log.instance_added(0, false);
  EXPECT_TRUE(log.take().empty());
  log.instance_moved(0);
  EXPECT_TRUE(log.take().empty());
  log.instance_shown(0, true);
  const ChangeSet set = log.take();
  EXPECT_TRUE(set.instance_set_changed);
  EXPECT_TRUE(set.moved_instances.empty()) << "nobody has seen another matrix";
  log.instance_moved(0);
  EXPECT_EQ(log.take().moved_instances, Ids{0});
}

TEST(ChangeLog, RemovingAnInstanceChangesTheSetOnlyIfItWasVisible) {
  ChangeLog log;
  log.instance_added(0, true);
  log.instance_added(1, false);
  log.take();
  log.instance_removed(1);
  EXPECT_TRUE(log.take().empty());
  log.instance_moved(0);
  log.instance_removed(0);
  const ChangeSet set = log.take();
  EXPECT_TRUE(set.instance_set_changed);
  EXPECT_TRUE(set.moved_instances.empty());
}

}  // namespace
}  // namespace regraft
