#include "regraft/bvh/crown.h"

namespace regraft::bvh {

namespace {

/// Excess beside which the rest does not count.
constexpr double nearly_all = 0.9;

}  // namespace

std::uint32_t damaged_part(const LivingBvh& tree) {
  std::uint32_t n = 0;
  for (;;) {
    const Node& node = tree.bvh.nodes[n];
    if (node.leaf()) return n;
    const double wanted = nearly_all * tree.excess(0);
    const std::uint32_t side = tree.excess(node.first) >= tree.excess(node.first + 1) ? 0 : 1;
    if (!(tree.excess(node.first + side) > wanted)) return n;
    n = node.first + side;
  }
}

void rebuild_crown(LivingBvh& tree, const Crown& crown, const PrimBoxes& boxes,
                   const BinnedSahBuilder::Config& builder, Executor& executor,
                   RestructureResult& result) {
  const Node& top = tree.bvh.nodes[crown.node];
  if (top.leaf()) return;
  const NodePair pair{top.first, top.first + 1, crown.node};
  const Graft graft = prepare_graft({tree, pair, boxes, builder, crown.parts}, executor);
  if (!graft.possible || !(graft.saving > 0.0)) return;
  const std::vector<std::uint32_t> made = apply_graft(tree, graft, crown.node);
  result.nodes_rebuilt += made.size();
  result.replaced.insert(result.replaced.end(), made.begin(), made.end());
  result.crown_saving = graft.saving / tree.area(0);
}

}  // namespace regraft::bvh
