#include "regraft/bvh/subtrees.h"

#include <algorithm>

#include "regraft/core/growth.h"

namespace regraft::bvh {

void splice(Bvh& bvh, const std::vector<Subtree>& subtrees, Executor& executor) {
  std::vector<std::size_t> offsets(subtrees.size());
  std::size_t total = bvh.nodes.size();
  for (std::size_t i = 0; i < subtrees.size(); ++i) {
    offsets[i] = total;
    total += subtrees[i].nodes.size() - 2;
    bvh.depth = std::max(bvh.depth, subtrees[i].depth);
  }
  grow(bvh.nodes, total);
  executor.parallel_for(subtrees.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto shift = std::uint32_t(offsets[i] - 2);
      const AlignedVector<Node>& nodes = subtrees[i].nodes;
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (n == 1) continue;
        Node node = nodes[n];
        if (!node.leaf()) node.first += shift;
        bvh.nodes[n == 0 ? subtrees[i].node : shift + n] = node;
      }
    }
  });
}

void close_top(Bvh& bvh, std::size_t count) {
  for (std::size_t n = count; n-- > 0;) {
    Node& node = bvh.nodes[n];
    if (n == 1 || node.leaf() || node.first >= count) continue;
    Aabb box = bvh.nodes[node.first].bounds();
    box.extend(bvh.nodes[node.first + 1].bounds());
    node.set_bounds(box);
  }
}

}  // namespace regraft::bvh
