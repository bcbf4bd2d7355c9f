#pragma once

#include <cstdint>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// A subtree built as a task of its own, to hang below `node` of a tree.
struct Subtree {
  std::uint32_t node = 0;
  AlignedVector<Node> nodes;  ///< element 0 is its root, element 1 unused
  std::uint32_t depth = 0;    ///< of its deepest leaf, in the whole tree
};

/// Makes `nodes` that of a tree whose root is still to be written.
inline void start_tree(AlignedVector<Node>& nodes) {
  nodes.resize(2);
  nodes[1] = {};
}

/// Room for a pair of children of nodes[node], which becomes an inner node. @return the first.
inline std::uint32_t make_inner(AlignedVector<Node>& nodes, std::uint32_t node) {
  const auto first = std::uint32_t(nodes.size());
  nodes.resize(nodes.size() + 2);
  nodes[node].first = first;
  nodes[node].count = 0;
  return first;
}

/// Appends the subtrees in their order and sets the depth.
void splice(Bvh& bvh, const std::vector<Subtree>& subtrees, Executor& executor);

/// Boxes of the first `count` nodes, parents before their children, from those below them.
void close_top(Bvh& bvh, std::size_t count);

}  // namespace regraft::bvh
