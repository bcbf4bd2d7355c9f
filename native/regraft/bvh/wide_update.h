#pragma once

#include <cstdint>
#include <vector>

#include "regraft/bvh/wide_slots.h"
#include "regraft/bvh/wide_treelet.h"
#include "regraft/core/growth.h"

namespace regraft::bvh {

/// The nodes of a wide layout with the ledger about them.
template <int W>
struct WideTarget {
  AlignedVector<WideNode<W>>& nodes;
  WideLedger& ledger;

  void resize(std::size_t count) const {
    grow(nodes, count);
    grow(ledger.root, count, WideLedger::none);
    grow(ledger.parent, count, WideLedger::none);
  }
};

/// Writes the nodes of a part, that of number i to where `place(i)` says, and the ledger about
/// them. Only the parent of number 0 is left to the caller.
template <int W, typename F>
void place_part(const Bvh& bvh, const WidePart<W>& part, const WideTarget<W>& target,
                const F& place) {
  constexpr std::size_t ahead = 4;
  for (std::uint32_t n = 0; n < part.items.size(); ++n) {
    if (n + ahead < part.items.size())
      for (const std::uint32_t slot : part.items[n + ahead].treelet.slots)
        __builtin_prefetch(bvh.nodes.data() + slot);
    const Treelet<W>& treelet = part.items[n].treelet;
    std::uint32_t next = part.items[n].first_child;
    const std::uint32_t at = place(n);
    WideNode<W>& node = target.nodes[at];
    fill_slots(bvh, treelet, node);
    target.ledger.root[at] = treelet.root_pair();
    for (std::uint32_t i = 0; i + 1 < treelet.count; ++i)
      target.ledger.owner[treelet.opened[i] / 2] = at;
    for (std::uint32_t i = 0; i < treelet.count; ++i) {
      if (bvh.nodes[treelet.slots[i]].leaf()) continue;
      node.child[i] = place(next++);
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

  /// @return the wide nodes that are now derived anew.
  std::vector<std::uint32_t> run(const Reshaping& changes);

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
  std::vector<std::uint32_t> remade_;
  std::vector<std::uint32_t> detached_;
  /// Slots whose wide nodes are still to be derived.
  struct Fresh {
    std::uint32_t wide;
    std::uint32_t slot;
    std::uint32_t binary;
  };
  std::vector<Fresh> fresh_;
};

extern template class WideUpdate<4>;
extern template class WideUpdate<8>;

}  // namespace regraft::bvh
