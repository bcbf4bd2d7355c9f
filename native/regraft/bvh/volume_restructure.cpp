#include "regraft/bvh/volume_restructure.h"

namespace regraft::bvh {

namespace {

constexpr double worn_share = 0.9;

void collect_worn(const LivingBvh& tree, std::uint32_t n, std::vector<NodePair>& worn) {
  const Node& node = tree.bvh.nodes[n];
  if (node.leaf() || tree.seen[node.first >> 1] == 0) return;
  if (tree.volume_ratio(n) < worn_share * double(tree.inner[node.first >> 1].volume_ratio)) {
    worn.push_back({node.first, node.first + 1, n});
    return;
  }
  collect_worn(tree, node.first, worn);
  collect_worn(tree, node.first + 1, worn);
}

}  // namespace

RestructureResult restructure_by_volume(LivingBvh& tree, const PrimBoxes& boxes,
                                        const BinnedSahBuilder::Config& builder,
                                        Executor& executor) {
  std::vector<NodePair> worn;
  if (!tree.bvh.empty()) collect_worn(tree, 0, worn);
  RestructureResult result;
  result.rebuild_instead = !worn.empty() && worn[0].ancestor == 0;
  if (result.rebuild_instead) return result;
  const double unit_damage = tree.unit_damage;
  // Nothing stays whole: this policy knows no parts in order.
  tree.unit_damage = -1.0;
  regraft_all(tree, worn, boxes, builder, executor, result);
  tree.unit_damage = unit_damage;
  return result;
}

double area_ratio_sum(const Bvh& bvh, Executor& executor) {
  constexpr std::size_t grain = 8192;
  std::vector<double> parts(bvh.nodes.size() / grain + 1, 0.0);
  executor.parallel_for(bvh.nodes.size(), grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t n = begin; n < end; ++n) {
      const Node& node = bvh.nodes[n];
      if (n == 1 || node.leaf() || node.first < 2) continue;
      const double below =
          half_area(bvh.nodes[node.first].bounds()) + half_area(bvh.nodes[node.first + 1].bounds());
      if (below > 0.0) sum += half_area(node.bounds()) / below;
    }
    parts[begin / grain] = sum;
  });
  double sum = 0.0;
  for (const double part : parts) sum += part;
  return sum;
}

}  // namespace regraft::bvh
