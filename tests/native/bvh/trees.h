#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "bvh/boxes.h"
#include "regraft/bvh/refit.h"

namespace regraft::test {

/// Gives a tree the boxes of moved primitives.
inline void refit_to(bvh::Bvh& tree, const Boxes& moved, unsigned threads = 2) {
  bvh::refit(
      tree, [&](std::uint32_t i) { return bvh::Box4(moved.boxes[i]); }, pool(threads));
}

/// (order[0], (order[1], (order[2], …))): as deep as a tree can be.
inline bvh::Bvh chain_tree(const Boxes& boxes, const std::vector<std::uint32_t>& order) {
  bvh::Bvh tree;
  tree.prim_ids = order;
  tree.depth = std::uint32_t(order.size() - 1);
  tree.nodes.resize(2 * order.size());
  std::fill(tree.nodes.begin(), tree.nodes.end(), bvh::Node{});
  std::uint32_t node = 0;
  for (std::uint32_t i = 0; i + 1 < order.size(); ++i) {
    tree.nodes[node].first = 2 + 2 * i;
    tree.nodes[2 + 2 * i].first = i;
    tree.nodes[2 + 2 * i].count = 1;
    node = 3 + 2 * i;
  }
  tree.nodes[node].first = std::uint32_t(order.size() - 1);
  tree.nodes[node].count = 1;
  refit_to(tree, boxes, 1);
  return tree;
}

inline std::uint32_t height_of(const bvh::Bvh& tree, std::uint32_t n) {
  const bvh::Node& node = tree.nodes[n];
  return node.leaf() ? 0
                     : 1 + std::max(height_of(tree, node.first), height_of(tree, node.first + 1));
}

/// All nodes below `n`, itself first.
inline std::vector<std::uint32_t> nodes_below(const bvh::Bvh& tree, std::uint32_t n) {
  std::vector<std::uint32_t> found{n};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bvh::Node& node = tree.nodes[found[i]];
    if (!node.leaf()) found.insert(found.end(), {node.first, node.first + 1});
  }
  return found;
}

}  // namespace regraft::test
