#include "regraft/bvh/edit_living.h"

#include <algorithm>

#include "regraft/core/growth.h"

namespace regraft::bvh {

namespace {

/// The node above a new pair is in order as it is, and counts as entered by rays.
void begin_pair(LivingBvh& tree, std::uint32_t above) {
  if (!tree.measured()) return;
  tree.set_reference(above);
  tree.seen[tree.bvh.nodes[above].first >> 1] = 1;
}

/// All below `root`. @return how many nodes that is, itself included.
std::uint64_t begin_subtree(LivingBvh& tree, std::uint32_t root) {
  std::uint64_t count = 0;
  std::vector<std::uint32_t> open{root};
  while (!open.empty()) {
    const std::uint32_t n = open.back();
    open.pop_back();
    ++count;
    if (tree.bvh.nodes[n].leaf()) continue;
    begin_pair(tree, n);
    const std::uint32_t first = tree.bvh.nodes[n].first;
    open.insert(open.end(), {first, first + 1});
  }
  return count;
}

}  // namespace

std::optional<std::uint64_t> edit(LivingBvh& tree, const PrimitiveEdit& change,
                                  const std::function<Box4(std::uint32_t)>& bounds,
                                  const BinnedSahBuilder::Config& builder, Executor& executor,
                                  Reshaping& changes) {
  if (!edit(tree.bvh, change, bounds, builder, executor, changes)) return std::nullopt;
  if (tree.measured()) {
    grow(tree.inner, tree.bvh.nodes.size() / 2);
    grow(tree.seen, tree.inner.size(), std::uint8_t(1));
  }
  std::uint64_t made = changes.replaced.size();
  for (const std::uint32_t n : changes.rebuilt) made += begin_subtree(tree, n);
  // Nodes that took over what is below another keep its proportions.
  std::vector<std::uint32_t> pairs = changes.new_pairs;
  std::sort(pairs.begin(), pairs.end());
  for (const std::uint32_t n : changes.replaced)
    if (!tree.bvh.nodes[n].leaf() &&
        std::binary_search(pairs.begin(), pairs.end(), tree.bvh.nodes[n].first))
      begin_pair(tree, n);
  return made;
}

}  // namespace regraft::bvh
