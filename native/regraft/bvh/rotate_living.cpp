#include "regraft/bvh/rotate_living.h"

#include <unordered_set>

namespace regraft::bvh {

namespace {

using Marked = std::unordered_set<std::uint32_t>;

void measure_marked(LivingBvh& tree, std::uint32_t n, const Marked& marked) {
  if (!marked.contains(n)) return;
  const std::uint32_t first = tree.bvh.nodes[n].first;
  measure_marked(tree, first, marked);
  measure_marked(tree, first + 1, marked);
  tree.measure(n);
}

}  // namespace

std::vector<Rotation> rotate(LivingBvh& tree, Executor& executor) {
  RotationScope scope;
  scope.settled = [&](std::uint32_t n) { return tree.in_order(n); };
  scope.height = [&](std::uint32_t n) { return tree.height(n); };
  const std::vector<Rotation> rotations = rotate(tree.bvh, scope, executor);
  for (const Rotation& r : rotations)
    for (const std::uint32_t n : {r.child, r.grandchild}) {
      const Node& node = tree.bvh.nodes[n];
      if (!node.leaf()) tree.inner[node.first >> 1].node = n;
    }
  Marked marked;
  for (const Rotation& r : rotations)
    for (const std::uint32_t changed : {r.child, r.grandchild}) {
      // A pair stays with its node wherever that is moved.
      std::uint32_t n = tree.inner[changed >> 1].node;
      tree.set_reference(n);
      while (marked.insert(n).second && n != 0) n = tree.parent(n);
    }
  measure_marked(tree, 0, marked);
  tree.bvh.depth = tree.height(0);
  return rotations;
}

}  // namespace regraft::bvh
