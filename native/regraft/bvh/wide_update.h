#pragma once

#include <cstdint>
#include <vector>

#include "regraft/bvh/wide_treelet.h"

namespace regraft::bvh {

/// The nodes of a wide layout with the ledger about them.
template <int W>
struct WideTarget {
  AlignedVector<WideNode<W>>& nodes;
  WideLedger& ledger;

  void resize(std::size_t count) const {
    nodes.resize(count);
    ledger.root.resize(count, WideLedger::none);
    ledger.parent.resize(count, WideLedger::none);
  }
};

/// Moves the nodes of a part to where `place(number in the part)` says. Only its root's parent is
/// left to the caller.
template <int W, typename F>
void place_part(const WidePart<W>& part, const WideTarget<W>& target, const F& place) {
  auto opened = part.opened.begin();
  for (std::size_t n = 0; n < part.nodes.size(); ++n) {
    const std::uint32_t at = place(n);
    WideNode<W>& node = target.nodes[at] = part.nodes[n];
    // A tree of one leaf opens nothing; no node has 0 for a child.
    target.ledger.root[at] = part.nodes[n].child[1] == WideChild::none ? 0 : *opened;
    for (int i = 0; i < W && node.child[i] != WideChild::none; ++i) {
      if (i > 0) target.ledger.owner[*opened++ / 2] = at;
      if (WideChild::is_leaf(node.child[i])) continue;
      node.child[i] = place(node.child[i]);
      target.ledger.parent[node.child[i]] = at;
    }
  }
}

/// One partial update of a wide layout; see WideBvh::update.
///
/// Wide nodes whose treelet has another shape are derived anew, from the root down. They keep
/// every wide node below them that still stands for a node of the binary tree, wherever it has
/// gone: those are not opened, so that change stays where it is, but taken in whole if they fit.
template <int W>
class WideUpdate {
 public:
  WideUpdate(const Bvh& bvh, WideTarget<W> target, Executor& executor)
      : bvh_(bvh), nodes_(target.nodes), ledger_(target.ledger), executor_(executor) {}

  void run(const Reshaping& changes);

 private:
  enum Mark : std::uint8_t { untouched, on_path, dirty, released };
  static constexpr std::uint32_t none = WideLedger::none;
  /// Owner of pairs that are in the binary tree for the first time, like everything below them.
  static constexpr std::uint32_t fresh = none - 1;

  void disown(std::uint32_t binary);
  void mark_dirty(std::uint32_t pair);
  void visit(std::uint32_t wide, std::uint32_t binary);
  void remake(std::uint32_t wide, std::uint32_t binary);
  void detach_children(std::uint32_t wide);
  void absorb(Treelet<W>& treelet);
  void link(std::uint32_t wide, const Treelet<W>& treelet);
  void derive_fresh();
  void release_detached();

  /// The wide node that stands for an inner binary node, or `none`.
  std::uint32_t rooted(std::uint32_t binary) const {
    const std::uint32_t first = bvh_.nodes[binary].first;
    const std::uint32_t owner = ledger_.owner[first / 2];
    return owner < nodes_.size() && ledger_.root[owner] == first ? owner : none;
  }
  std::uint32_t allocate();

  const Bvh& bvh_;
  AlignedVector<WideNode<W>>& nodes_;
  WideLedger& ledger_;
  Executor& executor_;
  std::vector<Mark> marks_;
  std::vector<std::uint32_t> detached_;
  std::vector<typename WidePart<W>::Open> fresh_;
};

extern template class WideUpdate<4>;
extern template class WideUpdate<8>;

}  // namespace regraft::bvh
