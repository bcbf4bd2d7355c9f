#include "regraft/bvh/sah.h"

#include <vector>

namespace regraft::bvh {

double sah_cost(const Bvh& bvh, const CostModel& cost) {
  if (bvh.empty()) return 0.0;
  struct Open {
    std::uint32_t node;
    double probability;
  };
  std::vector<Open> open{{0, 1.0}};
  double sum = 0.0;
  while (!open.empty()) {
    const Open item = open.back();
    open.pop_back();
    const Node& node = bvh.nodes[item.node];
    sum += item.probability * (node.leaf() ? node.count * cost.leaf : 1.0);
    for (std::uint32_t c = node.first; !node.leaf() && c < node.first + 2; ++c)
      open.push_back({c, item.probability * hit_probability(bvh.nodes[c].bounds(), node.bounds())});
  }
  return sum;
}

}  // namespace regraft::bvh
