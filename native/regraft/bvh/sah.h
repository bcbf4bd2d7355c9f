#pragma once

#include "regraft/bvh/bvh.h"

namespace regraft::bvh {

/// Costs in units of one ray/box test (algorithms: Yoon, Curtis, Manocha 2007, section 4).
struct CostModel {
  /// Cost of one ray/triangle test.
  double leaf = 1.5;
};

/// Expected tests of a ray that hits the root's box: C(root) of Eq. 1 with every node visible,
/// C(leaf) = count·leaf, C(inner) = 1 + Σ P(child|n)·C(child). 0 for the empty tree.
double sah_cost(const Bvh& bvh, const CostModel& cost = {});

}  // namespace regraft::bvh
