#include "regraft/bvh/local_refit.h"

#include <algorithm>
#include <atomic>

#include "regraft/core/growth.h"

namespace regraft::bvh {

namespace {

constexpr std::size_t grain = 16384;

}  // namespace

void LocalRefit::resize(const Bvh& bvh) {
  const std::size_t pairs = bvh.nodes.size() / 2;
  grow(above_, pairs);
  grow(marks_, pairs);
  grow(below_, pairs);
}

/// Notes where the primitives of a leaf are, or what is above the children of an inner node.
void LocalRefit::connect(const Bvh& bvh, std::uint32_t node) {
  const Node& n = bvh.nodes[node];
  for (std::uint32_t i = 0; i < n.count; ++i) leaf_of_[bvh.prim_ids[n.first + i]] = node;
  // Nodes of pairs that are not in use have no children.
  if (!n.leaf() && n.first >= 2) above_[n.first >> 1] = node;
}

void LocalRefit::link(const Bvh& bvh, Executor& executor) {
  const auto last = std::max_element(bvh.prim_ids.begin(), bvh.prim_ids.end());
  leaf_of_.assign(last == bvh.prim_ids.end() ? 0 : *last + std::size_t(1), none);
  resize(bvh);
  std::fill(marks_.begin(), marks_.end(), std::uint8_t(0));
  executor.parallel_for(bvh.nodes.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n)
      if (n != 1) connect(bvh, std::uint32_t(n));
  });
  is_summed_ = false;
}

void LocalRefit::relink(const Bvh& bvh, std::span<const std::uint32_t> nodes) {
  resize(bvh);
  for (const std::uint32_t n : nodes) connect(bvh, n);
  for (const std::uint32_t n : nodes) {
    climb(n);
    if (!bvh.nodes[n].leaf()) touch_pair(bvh.nodes[n].first >> 1);
  }
}

void LocalRefit::touch_all() {
  marks_.assign(marks_.size(), first_child | second_child | own);
  is_summed_ = false;
}

void LocalRefit::touch_prims(std::span<const std::uint32_t> prims, Executor& executor) {
  executor.parallel_for(prims.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t prim : prims.subspan(begin, end - begin))
      if (prim < leaf_of_.size() && leaf_of_[prim] != none) climb(leaf_of_[prim]);
  });
}

void LocalRefit::touch_pair(std::uint32_t pair) {
  const bool is_known = marks_[pair] != 0;
  marks_[pair] |= own;
  if (!is_known) climb(above_[pair]);
}

/// Marks a node, and the way to it from the root as far as it is not marked yet: whoever marked a
/// pair first, perhaps in another thread, goes on upwards.
void LocalRefit::climb(std::uint32_t node) {
  while (node != 0) {
    const auto bit = std::uint8_t(first_child << (node & 1));
    const std::atomic_ref<std::uint8_t> mark(marks_[node >> 1]);
    const std::uint8_t before = mark.load(std::memory_order_relaxed);
    if ((before & bit) != 0 || mark.fetch_or(bit, std::memory_order_relaxed) != 0) return;
    node = above_[node >> 1];
  }
}

/// Marked nodes that do not lie below each other, to be visited as tasks of their own.
std::vector<std::uint32_t> LocalRefit::frontier(const Bvh& bvh) const {
  // More tasks the more there is to do: a few marked nodes are not worth another thread.
  constexpr std::size_t tasks = 64;
  std::vector<std::uint32_t> nodes{0};
  std::vector<std::uint32_t> next;
  while (!nodes.empty() && nodes.size() < tasks) {
    next.clear();
    for (const std::uint32_t n : nodes) {
      const std::uint32_t first = bvh.nodes[n].first;
      for (std::uint32_t side = 0; side < 2; ++side)
        if ((marks_[first >> 1] & (first_child << side)) != 0 && !bvh.nodes[first + side].leaf())
          next.push_back(first + side);
    }
    nodes.swap(next);
  }
  return nodes;
}

RefitResult LocalRefit::finish(const LivingBvh& tree, const std::vector<Part>& parts) {
  touched_all_ = !std::exchange(is_summed_, true);
  if (touched_all_) std::fill(marks_.begin(), marks_.end(), std::uint8_t(0));
  touched_.clear();
  const Below& all = below_[tree.bvh.nodes[0].first >> 1];
  detail::RefitSum sum{all.tests + half_area(tree.bvh.nodes[0].bounds()), all.prim_area, 0};
  for (const Part& part : parts) {
    sum.nodes += part.nodes;
    if (!touched_all_) touched_.insert(touched_.end(), part.pairs.begin(), part.pairs.end());
  }
  return detail::finish_refit(tree.bvh, sum, tree.model);
}

std::size_t LocalRefit::bytes() const {
  return (leaf_of_.capacity() + above_.capacity() + touched_.capacity()) * sizeof(std::uint32_t) +
         marks_.capacity() + below_.capacity() * sizeof(Below);
}

}  // namespace regraft::bvh
