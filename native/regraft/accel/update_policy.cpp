#include "regraft/accel/update_policy.h"

namespace regraft::accel {

TreeUpdate choose_update(const TreeState& tree, Policy policy) {
  if (!tree.exists || tree.topology_changed) return TreeUpdate::rebuild;
  if (!tree.moved) return TreeUpdate::none;
  switch (policy) {
    case Policy::rebuild:
      return TreeUpdate::rebuild;
    case Policy::refit:
      return TreeUpdate::refit;
    case Policy::automatic:
      break;
  }
  return tree.wear > worn_out ? TreeUpdate::rebuild : TreeUpdate::refit;
}

std::string_view name(Policy policy) {
  switch (policy) {
    case Policy::refit:
      return "refit";
    case Policy::rebuild:
      return "rebuild";
    case Policy::automatic:
      break;
  }
  return "auto";
}

std::string_view name(Layout layout) {
  return layout == Layout::flat ? "flat" : "two-level";
}

}  // namespace regraft::accel
