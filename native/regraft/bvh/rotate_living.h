#pragma once

#include <vector>

#include "regraft/bvh/living_bvh.h"
#include "regraft/bvh/rotate.h"

namespace regraft::bvh {

/// One pass of rotations over what is damaged of a measured tree. Its metrics follow, and nodes
/// that now hold other children are taken as put in order.
std::vector<Rotation> rotate(LivingBvh& tree, Executor& executor);

}  // namespace regraft::bvh
