#include "regraft/accel/ray_marks.h"

#include <algorithm>

namespace regraft::accel {

void RayMarks::reset(const bvh::WideBvh& wide) {
  entered_.assign(wide.node_count(), 0);
  told_.assign(wide.node_count(), unknown);
}

void RayMarks::begin(const bvh::WideBvh& wide, bool is_remade) {
  entered_.assign(wide.node_count(), 0);
  if (!is_remade) return;
  told_.resize(wide.node_count(), unknown);
  for (const std::uint32_t node : wide.remade()) told_[node] = unknown;
}

void RayMarks::tell(const bvh::WideBvh& wide, bool is_known, bvh::LivingBvh& tree,
                    Executor& executor) {
  if (!tree.measured()) return;
  if (is_known) {
    wide.spread_marks(entered_, tree.seen, executor);
    told_ = entered_;
  } else {
    tree.see_all();
    told_.assign(told_.size(), 1);
  }
}

void RayMarks::tell_changes(const bvh::WideBvh& wide, bool is_known, bvh::LivingBvh& tree,
                            std::vector<std::uint32_t>& changed) {
  if (!tree.measured()) return;
  if (!is_known) std::fill(entered_.begin(), entered_.end(), std::uint8_t(1));
  wide.spread_marks(entered_, told_, tree.seen, tree.bvh, changed);
}

}  // namespace regraft::accel
