#include "regraft/accel/update_policy.h"

#include <algorithm>

namespace regraft::accel {

namespace {

/// RT-DEFORM rebuilds when the sum of ratios has changed by this much (Lauterbach, Yoon, Tuft,
/// Manocha, RT-DEFORM, RT 2006, section 3.2).
constexpr double rtdeform_change = 1.4;

/// Frames between two looks at a tree that never needs any.
constexpr std::uint32_t longest_interval = 16;
constexpr double hysteresis = 1.5;

}  // namespace

void Habit::note(TreeUpdate done, const Look& look) {
  ++frames_;
  rebuilds_ = done == TreeUpdate::rebuild ? rebuilds_ + 1 : 0;
  if (!measures() && done != TreeUpdate::rebuild) {
    ++waited_;
    return;
  }
  // What is won back was lost bit by bit, half of it on average, in each frame since the last look.
  const double lost = 0.5 * look.gain * (waited_ + 1);
  if (done != TreeUpdate::rebuild && lost < look.price / hysteresis)
    interval_ = std::min(2 * interval_, longest_interval);
  if (lost > look.price * hysteresis) interval_ = std::max(interval_ / 2, 1u);
  waited_ = 0;
  is_alarmed_ = false;
}

TreeUpdate choose_update(const TreeState& tree, Policy policy) {
  if (!tree.exists || tree.topology_changed) return TreeUpdate::rebuild;
  if (!tree.moved) return TreeUpdate::none;
  switch (policy) {
    case Policy::rebuild:
      return TreeUpdate::rebuild;
    case Policy::refit:
    case Policy::shot:
      return TreeUpdate::refit;
    case Policy::rtdeform:
      return tree.refitted && tree.ratio_change > rtdeform_change ? TreeUpdate::rebuild
                                                                  : TreeUpdate::refit;
    case Policy::automatic:
      if (tree.overpaid) return TreeUpdate::rebuild;
      if (tree.habit.rebuilds_blindly()) return TreeUpdate::rebuild;
      if (!tree.habit.measures()) return TreeUpdate::refit;
      break;
    case Policy::lm:
      return tree.refitted ? TreeUpdate::restructure : TreeUpdate::refit;
    case Policy::selective:
    case Policy::selective_rotate:
      break;
  }
  if (!tree.refitted) return TreeUpdate::refit;
  return tree.worth_rebuilding || tree.overpaid ? TreeUpdate::rebuild : TreeUpdate::restructure;
}

bool wants_metrics(Policy policy, const Habit& habit) {
  switch (policy) {
    case Policy::lm:
    case Policy::selective:
    case Policy::selective_rotate:
      return true;
    case Policy::automatic:
      return habit.measures();
    case Policy::refit:
    case Policy::rebuild:
    case Policy::rtdeform:
    case Policy::shot:
      break;
  }
  return false;
}

std::string_view name(Policy policy) {
  switch (policy) {
    case Policy::refit:
      return "refit";
    case Policy::rebuild:
      return "rebuild";
    case Policy::lm:
      return "lm";
    case Policy::rtdeform:
      return "rtdeform";
    case Policy::selective:
      return "selective";
    case Policy::selective_rotate:
      return "selective+rotate";
    case Policy::shot:
      return "shot";
    case Policy::automatic:
      break;
  }
  return "auto";
}

std::string_view name(Structure structure) {
  return structure == Structure::kdtree ? "kdtree" : "bvh";
}

std::string_view name(Layout layout) {
  return layout == Layout::flat ? "flat" : "two-level";
}

}  // namespace regraft::accel
