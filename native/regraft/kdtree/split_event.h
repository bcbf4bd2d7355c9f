#pragma once

#include <cstdint>
#include <span>

#include "regraft/kdtree/plane_cost.h"

namespace regraft::kdtree {

/// A bound of an entry, strictly inside the voxel: a place where a plane may be put. An entry
/// without extent is one event, not two.
struct SplitEvent {
  enum class Kind : std::uint32_t { start, end, flat };
  float position;
  Kind kind;
  double weight;
};

/// What a search for the cheapest plane is about.
struct SplitProblem {
  const SplitCost& cost;
  const ChildProbability& probability;
};

/// Offers `best` every plane through one of `events`, all of one axis, which it sorts. `sides`:
/// the weights left and right of a plane just below the first of them.
void sweep_events(Split& best, const SplitProblem& problem, int axis, std::span<SplitEvent> events,
                  Sides sides);

}  // namespace regraft::kdtree
