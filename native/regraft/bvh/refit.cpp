#include "regraft/bvh/refit.h"

#include <algorithm>

namespace regraft::bvh::detail {

std::vector<std::uint32_t> refit_frontier(const Bvh& bvh) {
  // Enough tasks to keep many cores busy, few enough that what is left above them is nothing.
  constexpr std::size_t tasks = 128;
  if (bvh.nodes.size() < 4 * tasks) return {0};
  std::vector<std::uint32_t> frontier{0};
  std::vector<std::uint32_t> next;
  while (frontier.size() < tasks) {
    next.clear();
    bool opened = false;
    for (const std::uint32_t index : frontier) {
      const Node& node = bvh.nodes[index];
      if (node.leaf()) {
        next.push_back(index);
        continue;
      }
      opened = true;
      next.push_back(node.first);
      next.push_back(node.first + 1);
    }
    if (!opened) break;
    frontier.swap(next);
  }
  std::sort(frontier.begin(), frontier.end());
  return frontier;
}

RefitResult finish_refit(const Bvh& bvh, const RefitSum& sum, const CostModel& model) {
  const double root_area = half_area(bvh.nodes[0].bounds());
  return {sum.nodes, root_area > 0.0 ? sum.cost / root_area : sah_cost(bvh, model),
          sum.prim_area > 0.0 ? sum.cost / sum.prim_area : 0.0};
}

}  // namespace regraft::bvh::detail
