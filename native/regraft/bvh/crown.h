#pragma once

#include "regraft/bvh/selective_restructure.h"

namespace regraft::bvh {

/// Builds the top of a tree anew over `parts` subtrees that stay whole, the largest and most
/// damaged opened first, if that makes the tree cheaper. Ours, after the cut that Hunt, Mark,
/// Fussell 2007 build from: excess cost is relative to a tree's own past, and does not see that a
/// scene has become one for which a far better tree exists, as when things fly apart.
///
/// The tree is measured and refitted.
void rebuild_crown(LivingBvh& tree, std::size_t parts, const PrimBoxes& boxes,
                   const BinnedSahBuilder::Config& builder, Executor& executor,
                   RestructureResult& result);

}  // namespace regraft::bvh
