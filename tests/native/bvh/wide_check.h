#pragma once

#include <set>
#include <string>

#include "bvh/boxes.h"
#include "regraft/bvh/wide_bvh.h"

namespace regraft::test {

template <int W>
Aabb slot_box(const bvh::WideNode<W>& node, int slot) {
  const auto plane = [&](int k) { return node.bounds[k][slot]; };
  return {Vec3(plane(0), plane(1), plane(2)), Vec3(plane(3), plane(4), plane(5))};
}

/// Walks a wide tree and collects what is wrong with it.
template <int W>
class WideCheck {
 public:
  WideCheck(const bvh::WideBvh& wide, const bvh::Bvh& bvh) : wide_(wide), bvh_(bvh) {}

  std::string flaw() {
    visit(0);
    if (flaw_.empty() && nodes_.size() + wide_.free_count() != wide_.node_count())
      flaw_ = "nodes are not reached";
    std::set<std::uint32_t> leaves;
    collect_leaves(0, leaves);
    if (flaw_.empty() && leaves_ != leaves) flaw_ = "leaves are missing";
    return flaw_;
  }

 private:
  void collect_leaves(std::uint32_t n, std::set<std::uint32_t>& leaves) const {
    if (bvh_.nodes[n].leaf()) {
      leaves.insert(n);
      return;
    }
    for (std::uint32_t side = 0; side < 2; ++side)
      collect_leaves(bvh_.nodes[n].first + side, leaves);
  }

  void visit(std::uint32_t index) {
    if (index >= wide_.node_count() || !nodes_.insert(index).second) {
      flaw_ = "a node is reached twice or out of range";
      return;
    }
    const bvh::WideNode<W>& node = wide_.nodes<W>()[index];
    bool ended = false;
    for (int i = 0; i < W && flaw_.empty(); ++i) {
      ended |= node.child[i] == bvh::WideChild::none;
      if (ended)
        check_unused(node, i);
      else
        check_used(node, i);
    }
  }

  void check_unused(const bvh::WideNode<W>& node, int slot) {
    if (node.child[slot] != bvh::WideChild::none) flaw_ = "an unused slot lies between used ones";
    if (!slot_box(node, slot).empty()) flaw_ = "an unused slot has a box";
  }

  void check_used(const bvh::WideNode<W>& node, int slot) {
    const bvh::Node& source = bvh_.nodes[node.source[slot]];
    if (!(slot_box(node, slot) == source.bounds())) flaw_ = "a box is not that of the binary tree";
    const std::uint32_t child = node.child[slot];
    if (!bvh::WideChild::is_leaf(child)) {
      if (source.leaf()) flaw_ = "a leaf became an inner node";
      visit(child);
      return;
    }
    if (!source.leaf() || bvh::WideChild::begin(child) != source.first ||
        bvh::WideChild::count(child) != source.count)
      flaw_ = "a leaf's range is not that of the binary tree";
    if (!leaves_.insert(node.source[slot]).second) flaw_ = "a leaf is there twice";
  }

  const bvh::WideBvh& wide_;
  const bvh::Bvh& bvh_;
  std::set<std::uint32_t> nodes_, leaves_;
  std::string flaw_;
};

/// "" if `wide` is a layout of `bvh`.
inline std::string flaw(const bvh::WideBvh& wide, const bvh::Bvh& bvh) {
  if (bvh.empty()) return wide.empty() ? "" : "an empty tree has no nodes";
  return wide.width() == 8 ? WideCheck<8>(wide, bvh).flaw() : WideCheck<4>(wide, bvh).flaw();
}

}  // namespace regraft::test
