#pragma once

#include <cstdint>
#include <limits>

#include "regraft/core/aabb.h"

namespace regraft::kdtree {

/// Something a plane can part from the rest: a primitive, or a node of the scene's hierarchy.
/// The box overlaps the voxel; what reaches beyond it is ignored.
struct SplitEntry {
  Aabb box;
  /// Primitives under it; 0 or less: it neither counts nor offers a plane. Sums stay exact, and
  /// so independent of the order of entries, for whole weights up to 2^53 in all.
  double weight = 1.0;
};

/// Cost of a plane: traverse + intersect·(P_left·W_left + P_right·W_right), of a leaf
/// intersect·W. Unit: one ray/box test. Wald and Havran, On building fast kd-trees, 2006, eq. 1;
/// with the probabilities of child_probability.h also Fabianowski et al. 2009, eq. 9 over p_P.
struct SplitCost {
  double traverse = 1.0;
  double intersect = 1.5;
  /// A plane that leaves one side empty is taken before all others if that side spans at least
  /// this part of the voxel along the axis (Fabianowski et al. 2009: 30 %). Above 1: never.
  double empty_cut = 0.3;
};

/// The cheapest plane over the three axes. Planes are bounds of entries, strictly inside the
/// voxel. lo < position goes left, hi > position goes right, both goes to both sides.
struct Split {
  int axis = -1;           ///< none: no plane beats the leaf
  float position = 0.0f;   ///< a bound of an entry
  bool flat_left = false;  ///< entries flat in the plane (lo = hi = position) go left
  /// Of the best plane found, also where it does not beat the leaf; infinite without a plane.
  double cost = std::numeric_limits<double>::infinity();
  /// Proven: no plane costs less. Equal to `cost` for an exact search and for an empty cut.
  double lower_bound = std::numeric_limits<double>::infinity();
  std::uint32_t samples = 0;  ///< planes whose cost was computed

  bool found() const { return axis >= 0; }
  /// cost/lower_bound − 1: the most by which the best plane can undercut this one.
  double certificate() const { return cost > lower_bound ? cost / lower_bound - 1.0 : 0.0; }
};

}  // namespace regraft::kdtree
