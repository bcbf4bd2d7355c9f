#pragma once

#include <string>
#include <vector>

#include "regraft/kdtree/plane_cost.h"

namespace regraft::test {

/// A voxel and what overlaps it.
struct SplitCase {
  Aabb voxel;
  std::vector<kdtree::SplitEntry> entries;
};

/// Kinds of distribution: uniform, clustered, grid, one huge among many, teapot in a stadium,
/// flat things, everything equal, reaching out of the voxel.
inline constexpr int split_case_kinds = 8;
SplitCase split_case(int kind, std::size_t count, std::uint32_t seed);

inline constexpr kdtree::SplitCost never_cut_empty{.empty_cut = 2.0};

/// The cheapest of all planes by counting for each of them, without the empty-space cut.
kdtree::Split brute_force_split(const SplitCase& c, const kdtree::ChildProbability& probability,
                                const kdtree::SplitCost& cost = {});
/// The cost of one plane, by counting.
double brute_force_cost(const SplitCase& c, const kdtree::ChildProbability& probability,
                        const kdtree::SplitCost& cost, int axis, float position);

}  // namespace regraft::test
