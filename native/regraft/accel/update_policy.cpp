#include "regraft/accel/update_policy.h"

namespace regraft::accel {

namespace {

/// RT-DEFORM rebuilds when the sum of ratios has changed by this much (Lauterbach, Yoon, Tuft,
/// Manocha, RT-DEFORM, RT 2006, section 3.2).
constexpr double rtdeform_change = 1.4;

}  // namespace

void Habit::note(TreeUpdate done) {
  ++frames;
  quiet = done == TreeUpdate::refit ? quiet + 1 : 0;
  rebuilds = done == TreeUpdate::rebuild ? rebuilds + 1 : 0;
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
