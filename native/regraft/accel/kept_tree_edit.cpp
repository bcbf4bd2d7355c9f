#include "regraft/accel/kept_tree.h"
#include "regraft/bvh/edit_living.h"

namespace regraft::accel {

bool KeptTree::edit(const bvh::PrimitiveEdit& change, std::size_t count,
                    const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
                    const Tending& how, Executor& executor, TreeWork& work) {
  const bool by_plan = how.policy == Policy::rebuild || how.policy == Policy::shot ||
                       (how.policy == Policy::automatic && habit_.rebuilds_blindly());
  const double prims = double(tree_.bvh.prim_ids.size());
  if (!exists_ || by_plan || wide_.width() != how.width || tree_.bvh.empty() ||
      double(edited_ + count) > bvh::max_edited_share * prims)
    return false;
  marks_.tell(wide_, how.traced, tree_, executor);
  bvh::Reshaping changes;
  const auto made = bvh::edit(tree_, change, boxes, builder, executor, changes);
  if (!made || tree_.bvh.empty()) return false;
  wide_.update(tree_.bvh, changes, executor);
  local_ = {};
  is_local_ = false;
  is_measured_ = tree_.measured();
  now_ = bvh::refit(tree_, boxes, executor);
  wide_.refit(tree_.bvh, executor);
  marks_.begin(wide_, true);
  edited_ += count;
  ++since_build_;
  life_.count_frame(tree_.bvh.node_count());
  life_.count_built(*made);
  made_ = std::move(changes.rebuilt);
  for (const std::uint32_t n : changes.replaced)
    if (tree_.bvh.nodes[n].leaf() || tree_.bvh.nodes[n].first != 0) made_.push_back(n);
  shaped_in_ = how.update;
  work.done = TreeUpdate::restructure;
  work.nodes_refitted += now_.nodes;
  work.nodes_rebuilt += *made;
  work.edited += count;
  return true;
}

}  // namespace regraft::accel
