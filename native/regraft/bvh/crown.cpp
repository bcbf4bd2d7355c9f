#include "regraft/bvh/crown.h"

namespace regraft::bvh {

void rebuild_crown(LivingBvh& tree, std::size_t parts, const PrimBoxes& boxes,
                   const BinnedSahBuilder::Config& builder, Executor& executor,
                   RestructureResult& result) {
  const Node& root = tree.bvh.nodes[0];
  if (root.leaf()) return;
  const NodePair pair{root.first, root.first + 1, 0};
  const Graft graft = prepare_graft({tree, pair, boxes, builder, parts}, executor);
  if (!graft.possible || !(graft.saving > 0.0)) return;
  const std::vector<std::uint32_t> made = apply_graft(tree, graft, 0);
  result.nodes_rebuilt += made.size();
  result.replaced.insert(result.replaced.end(), made.begin(), made.end());
  result.crown_saving = graft.saving / tree.area(0);
}

}  // namespace regraft::bvh
