#pragma once

#include <cstdint>
#include <vector>

#include "regraft/bvh/living_bvh.h"
#include "regraft/bvh/wide_bvh.h"
#include "regraft/core/executor.h"

namespace regraft::accel {

/// Where rays mark the wide nodes that they enter, and what trees are told of it: C counts only
/// what was entered since the update before.
class RayMarks {
 public:
  /// A layout of another shape altogether. Nothing is known of its nodes.
  void reset(const bvh::WideBvh& wide);
  /// The layout's `remade` nodes are new; rays begin to mark anew.
  void begin(const bvh::WideBvh& wide, bool is_remade);

  /// Tells a measured tree what rays entered; if they are not known, everything was.
  void tell(const bvh::WideBvh& wide, bool is_known, bvh::LivingBvh& tree, Executor& executor);
  /// The same, looking only at what is not as the last time; `changed` receives the pairs of nodes
  /// that now count otherwise.
  void tell_changes(const bvh::WideBvh& wide, bool is_known, bvh::LivingBvh& tree,
                    std::vector<std::uint32_t>& changed);

  /// Whether rays entered the tree.
  bool any() const { return !entered_.empty() && entered_[0] != 0; }
  std::uint8_t* entered() const { return entered_.data(); }
  std::size_t bytes() const { return entered_.capacity() + told_.capacity(); }

 private:
  static constexpr std::uint8_t unknown = 2;
  mutable std::vector<std::uint8_t> entered_;  ///< by wide node
  std::vector<std::uint8_t> told_;             ///< what the tree was last told of each
};

}  // namespace regraft::accel
