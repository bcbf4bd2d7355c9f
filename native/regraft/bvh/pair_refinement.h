#pragma once

#include <vector>

#include "regraft/bvh/restructuring_benefit.h"

namespace regraft::bvh {

/// Algorithm 1 of Yoon, Curtis, Manocha 2007: from the pair of the root's children downwards, pairs
/// are looked at as long as the benefit in view exceeds the cost of looking; the benefit of each
/// counts for all pairs it is a refinement of.
///
/// Deviations, each measured in the tests: only damaged ancestors are refined, so that a tree as
/// good as at its build costs one pair; pairs that do not overlap are refined by what they could
/// hold, since their own benefit is 0.
/// @return all pairs, each once, parents first; the first is that of the root's children.
std::vector<NodePair> refine_pairs(const LivingBvh& tree, const RestructuringBenefit& metric,
                                   const RestructureConfig& config);

}  // namespace regraft::bvh
