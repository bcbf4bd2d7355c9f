#pragma once

#include "ray_batch.h"
#include "regraft/core/executor.h"

namespace regraft::bindings {

/// Puts a large batch in an order in which neighbours start near each other and go the same way,
/// so that they meet the same nodes; leaves a small one alone. Hits do not depend on it. `room`
/// holds the order and lives as long as the batch is read. O(rays).
void sort_rays(RayBatch& batch, AlignedVector<bvh::KeyedId>& room, Executor& executor);

}  // namespace regraft::bindings
