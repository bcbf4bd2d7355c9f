#include "regraft/bvh/sah.h"

#include <vector>

namespace regraft::bvh {

double sah_cost(const Bvh& bvh, const CostModel& cost) {
  if (bvh.empty()) return 0.0;
  // Children come after their parents, so one sweep hands every probability down.
  std::vector<double> probability(bvh.nodes.size(), 0.0);
  probability[0] = 1.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
    const Node& node = bvh.nodes[i];
    if (i == 1) continue;
    if (node.leaf()) {
      sum += probability[i] * node.count * cost.leaf;
      continue;
    }
    sum += probability[i];
    for (std::uint32_t c = node.first; c < node.first + 2; ++c)
      probability[c] = probability[i] * hit_probability(bvh.nodes[c].bounds(), node.bounds());
  }
  return sum;
}

}  // namespace regraft::bvh
