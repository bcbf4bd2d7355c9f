#include "regraft/kdtree/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace regraft::kdtree {

double Statistics::quality(double primitives, const SplitCost& cost) const {
  if (!(primitives > 1.0) || leaves == 0) return std::numeric_limits<double>::quiet_NaN();
  const double mean_leaf = cost.intersect * double(references) / double(leaves);
  return std::pow(sam_cost / (mean_leaf * primitives), 1.0 / std::log2(primitives));
}

Statistics measure(const KdTree& tree) {
  struct Cell {
    const Node* node;
    Aabb voxel;
    std::uint32_t depth;
  };
  Statistics s;
  const SplitCost& cost = tree.config().cost;
  std::vector<Cell> stack{{&tree.root(), tree.bounds(), 0}};
  while (!stack.empty()) {
    const Cell cell = stack.back();
    stack.pop_back();
    const double visited = hit_probability(cell.voxel, tree.bounds());
    const std::uint32_t state = cell.node->state.load(std::memory_order_acquire);
    s.depth = std::max(s.depth, cell.depth);
    if (Node::is_inner(state)) {
      ++s.inner;
      s.sam_cost += visited * cost.traverse;
      Cell child[2] = {{cell.node->children, cell.voxel, cell.depth + 1},
                       {cell.node->children + 1, cell.voxel, cell.depth + 1}};
      child[0].voxel.hi[int(state)] = child[1].voxel.lo[int(state)] = cell.node->split;
      stack.insert(stack.end(), {child[1], child[0]});
      continue;
    }
    if (Node::is_built(state)) {
      const std::uint32_t prims = Node::prim_count(state);
      ++s.leaves;
      s.references += prims;
      s.large_leaves += prims > large_leaf;
      s.largest_leaf = std::max(s.largest_leaf, prims);
      s.sam_cost += visited * cost.intersect * prims;
    } else {
      ++s.unbuilt;
    }
  }
  const double waiting = tree.pending_weight();
  const double all = double(s.references) + waiting;
  s.built_fraction = all > 0.0 ? double(s.references) / all : 1.0;
  s.bytes = tree.bytes();
  return s;
}

}  // namespace regraft::kdtree
