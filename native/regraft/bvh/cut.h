#pragma once

#include <vector>

#include "regraft/bvh/living_bvh.h"

namespace regraft::bvh {

/// What a subtree is taken apart into: parts of it that are in order stay whole.
struct Cut {
  /// A unit's root as it was: an inner node for a whole subtree; for a single primitive a leaf of
  /// one, at its place in `Bvh::prim_ids`.
  std::vector<Node> units;
  /// First nodes of the pairs that were opened.
  std::vector<std::uint32_t> pairs;
  /// Σ area·tests of what was opened.
  double tests = 0.0;

  /// Opens `node` down to what is neither damaged nor has an area above `large`. Opened leaves
  /// fall apart into primitives, their boxes still to be filled in.
  void open(const LivingBvh& tree, std::uint32_t node, double large);

  /// Opens two nodes, and always what is largest and most damaged of what they hold, until there
  /// are `count` units; what no ray entered stays whole. Returns how many units are of the first.
  std::size_t open_worst(const LivingBvh& tree, std::uint32_t a, std::uint32_t b,
                         std::size_t count);

 private:
  void take_apart(const Node& leaf);
};

}  // namespace regraft::bvh
