#pragma once

#include <string>

#include "regraft/kdtree/kdtree.h"

namespace regraft::kdtree {

/// Checks what exists of a tree, while nobody traces: planes strictly inside their cells, depth
/// within the builder's bound, leaves in order; every primitive named by each cell that it meets
/// inside, and by at least one that it touches (J2, J7); no entry of an unbuilt node within another
/// of its list (J2). Opens the whole hierarchy: O(cells · primitives), for tests.
/// @return the first violation in words, or "".
std::string validate(const KdTree& tree);

}  // namespace regraft::kdtree
