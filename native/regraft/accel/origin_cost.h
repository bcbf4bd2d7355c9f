#pragma once

#include "regraft/accel/tlas.h"

namespace regraft::accel {

/// Expected tests of a ray that starts anywhere in the scene's box and goes anywhere: as
/// `Tlas::sah_cost`, with p_N in the place of areas (Fabianowski, Fowler, Dingliana, Eurographics
/// 2009, eq. 9; p_N by eq. 5). Nodes of meshes count with their boxes in the world. O(nodes), once
/// an instance.
double origin_cost(const Tlas& tlas, const InstanceSet& instances, bool two_level);

}  // namespace regraft::accel
