#pragma once

#include "regraft/bvh/selective_restructure.h"

namespace regraft::bvh {

/// The top of what is below `node`, down to `parts` subtrees.
struct Crown {
  std::uint32_t node = 0;
  std::size_t parts = 0;
};

/// The lowest node that holds nearly all that was lost (Eq. 7) in a measured tree.
std::uint32_t damaged_part(const LivingBvh& tree);

/// Builds the crown of a tree anew over subtrees that stay whole, the largest and most damaged
/// opened first, if that makes the tree cheaper. Ours, after the cut that Hunt, Mark,
/// Fussell 2007 build from: excess cost is relative to a tree's own past, and does not see that a
/// scene has become one for which a far better tree exists, as when things fly apart.
///
/// The tree is measured and refitted.
void rebuild_crown(LivingBvh& tree, const Crown& crown, const PrimBoxes& boxes,
                   const BinnedSahBuilder::Config& builder, Executor& executor,
                   RestructureResult& result);

}  // namespace regraft::bvh
