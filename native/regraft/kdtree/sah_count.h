#pragma once

#include <cstddef>
#include <span>

#include "regraft/kdtree/plane_cost.h"

namespace regraft::kdtree {

/// Entries up to which `count_split` is meant.
inline constexpr std::size_t most_counted = 64;

/// Whether `count_split` can do without doubles: whole weights that sum up to at most 2^24.
bool countable(std::span<const SplitEntry> entries);

/// The split of `SahSweep`, empty cuts left aside, for a few `countable` entries: nothing is
/// sorted; for every bound of an entry the entries beside it are counted, four planes at once. It
/// takes n² comparisons, and up to 50 entries a third of the sorted sweep's time.
Split count_split(std::span<const SplitEntry> entries, const ChildProbability& probability,
                  const SplitCost& cost);

}  // namespace regraft::kdtree
