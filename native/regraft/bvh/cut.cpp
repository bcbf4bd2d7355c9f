#include "regraft/bvh/cut.h"

namespace regraft::bvh {

void Cut::open(const LivingBvh& tree, std::uint32_t n, double large) {
  const Node& node = tree.bvh.nodes[n];
  if (node.leaf()) {
    tests += tree.area(n) * tree.cost(n);
    for (std::uint32_t i = 0; i < node.count; ++i) {
      Node prim;
      prim.first = node.first + i;
      prim.count = 1;
      units.push_back(prim);
    }
    return;
  }
  if (tree.in_order(n) && !(tree.area(n) > large)) {
    units.push_back(node);
    return;
  }
  tests += tree.area(n);
  pairs.push_back(node.first);
  open(tree, node.first, large);
  open(tree, node.first + 1, large);
}

}  // namespace regraft::bvh
