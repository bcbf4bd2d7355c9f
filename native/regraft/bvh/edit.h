#pragma once

#include <functional>
#include <span>
#include <vector>

#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/box4.h"
#include "regraft/bvh/bvh.h"
#include "regraft/bvh/wide_bvh.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// How the primitives of a tree have changed.
struct PrimitiveEdit {
  /// New id of each old primitive, `invalid_id` for one that is gone. Empty: all keep theirs.
  std::span<const std::uint32_t> new_ids;
  /// Ids of new primitives, in chunks that belong together, such as connected ones.
  std::span<const std::vector<std::uint32_t>> added;
};

/// Largest share of primitives to be added or removed for which an edit is worth more than a build.
inline constexpr double max_edited_share = 0.3;

/// Changes the primitives of a tree without building it anew. What is removed is dropped from its
/// leaf, and the parent of an empty leaf gives way to the sibling. Each chunk of what is added is
/// built as a tree of its own and inserted where areas grow least, found by branch and bound
/// (Bittner, Hapala, Havran, Fast Insertion-Based Optimization of Bounding Volume Hierarchies,
/// Computer Graphics Forum 2013, section 3.2). `bounds(i)` is the present box of primitive i by its
/// new id; all boxes of the tree are right afterwards. Room in `prim_ids` that removals leave is
/// not used again before it is more than half of all. O(nodes), and O(log n) a chunk as a rule.
/// @return false, with the tree in no usable state, if it would grow too deep: build it anew.
bool edit(Bvh& bvh, const PrimitiveEdit& change, const std::function<Box4(std::uint32_t)>& bounds,
          const BinnedSahBuilder::Config& builder, Executor& executor, Reshaping& changes);

}  // namespace regraft::bvh
