#pragma once

#include "regraft/bvh/selective_restructure.h"

namespace regraft::bvh {

/// Rebuilds each highest subtree whose volume has become small against that of its children
/// together (Larsson, Akenine-Möller, A Dynamic Bounding Volume Hierarchy for Generalized Collision
/// Detection, Computers & Graphics 2006, section 4): V(n)/(V(L)+V(R)) has fallen below nine tenths
/// of what it was when built. Only what rays entered: the paper rebuilds when a node is reached.
///
/// Deviation: relative to the build, since surfaces have nodes without volume and with overlap that
/// no rebuild can mend.
RestructureResult restructure_by_volume(LivingBvh& tree, const PrimBoxes& boxes,
                                        const BinnedSahBuilder::Config& builder,
                                        Executor& executor);

/// Σ A(n)/(A(L)+A(R)) over all inner nodes, by which RT-DEFORM judges a tree (Lauterbach, Yoon,
/// Tuft, Manocha, RT 2006, section 3.2).
double area_ratio_sum(const Bvh& bvh, Executor& executor);

}  // namespace regraft::bvh
