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

RefitResult finish_refit(Bvh& bvh, const std::vector<std::uint32_t>& frontier,
                         const std::vector<RefitSum>& sums, const CostModel& model) {
  RefitSum sum;
  for (const RefitSum& s : sums) {
    sum.cost += s.cost;
    sum.prim_area += s.prim_area;
    sum.nodes += s.nodes;
  }
  const auto above = [&](const auto& self, std::uint32_t index) -> Aabb {
    Node& node = bvh.nodes[index];
    if (std::binary_search(frontier.begin(), frontier.end(), index)) return node.bounds();
    Aabb box = self(self, node.first);
    box.extend(self(self, node.first + 1));
    node.set_bounds(box);
    sum.cost += half_area(box);
    ++sum.nodes;
    return box;
  };
  above(above, 0);
  const double root_area = half_area(bvh.nodes[0].bounds());
  return {sum.nodes, root_area > 0.0 ? sum.cost / root_area : sah_cost(bvh, model),
          sum.prim_area > 0.0 ? sum.cost / sum.prim_area : 0.0};
}

}  // namespace regraft::bvh::detail
