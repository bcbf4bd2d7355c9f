#include "regraft/bvh/cut.h"

#include <algorithm>

namespace regraft::bvh {

namespace {

/// A node is the more urgent to open the more area it has, times the share of its cost that was
/// lost in it; this much is added to the share, for what is large but sound.
constexpr double soundness_weight = 0.02;

/// What may still be opened, the most urgent on top; ties: the lowest node.
struct Candidate {
  double urgency;
  std::uint32_t node;
  std::uint32_t side;
  bool operator<(const Candidate& other) const {
    return urgency != other.urgency ? urgency < other.urgency : node > other.node;
  }
};

}  // namespace

void Cut::take_apart(const Node& leaf) {
  for (std::uint32_t i = 0; i < leaf.count; ++i) {
    Node prim{};
    prim.first = leaf.first + i;
    prim.count = 1;
    units.push_back(prim);
  }
}

std::size_t Cut::open_worst(const LivingBvh& tree, std::uint32_t a, std::uint32_t b,
                            std::size_t count) {
  const AlignedVector<Node>& nodes = tree.bvh.nodes;
  const auto rank = [&](std::uint32_t n) {
    return soundness_weight * tree.area(n) + tree.excess(n) / tree.cost(n);
  };
  std::vector<Candidate> heap{{rank(a), a, 0}, {rank(b), b, 1}};
  std::vector<Node> of_side[2];
  const auto keep = [&](std::uint32_t n, std::uint32_t side) { of_side[side].push_back(nodes[n]); };
  std::size_t kept = 0;
  std::make_heap(heap.begin(), heap.end());
  while (!heap.empty() && kept + heap.size() < count) {
    std::pop_heap(heap.begin(), heap.end());
    const Candidate top = heap.back();
    heap.pop_back();
    const Node& node = nodes[top.node];
    if (node.leaf() || tree.seen[node.first >> 1] == 0) {
      keep(top.node, top.side);
      kept += std::max(node.count, 1u);
      continue;
    }
    tests += tree.area(top.node);
    pairs.push_back(node.first);
    for (std::uint32_t child = node.first; child < node.first + 2; ++child) {
      heap.push_back({rank(child), child, top.side});
      std::push_heap(heap.begin(), heap.end());
    }
  }
  for (const Candidate& rest : heap) keep(rest.node, rest.side);
  std::size_t first = 0;
  for (std::uint32_t side = 0; side < 2; ++side) {
    for (const Node& node : of_side[side]) {
      if (!node.leaf()) {
        units.push_back(node);
        continue;
      }
      double each = 0.0;
      for (std::uint32_t i = 0; i < node.count; ++i)
        each += tree.prim_cost(tree.bvh.prim_ids[node.first + i]);
      tests += half_area(node.bounds()) * each;
      take_apart(node);
    }
    if (side == 0) first = units.size();
  }
  return first;
}

void Cut::open(const LivingBvh& tree, std::uint32_t n, double large) {
  const Node& node = tree.bvh.nodes[n];
  if (node.leaf()) {
    tests += tree.area(n) * tree.cost(n);
    take_apart(node);
    return;
  }
  if (tree.in_order(n) && !(tree.area(n) > large)) {
    units.push_back(node);
    return;
  }
  tests += tree.area(n);
  pairs.push_back(node.first);
  open(tree, node.first, large);
  open(tree, node.first + 1, large);
}

}  // namespace regraft::bvh
