#include "regraft/bvh/wide_update.h"

#include <algorithm>

namespace regraft::bvh {

template <int W>
std::vector<std::uint32_t> WideUpdate<W>::run(const Reshaping& changes) {
  marks_.assign(nodes_.size(), untouched);
  grow(ledger_.owner, bvh_.nodes.size() / 2, none);
  for (const std::uint32_t n : changes.rebuilt) mark_dirty(n / 2);
  for (const std::uint32_t n : changes.replaced) mark_dirty(n / 2);
  executor_.parallel_for(changes.rebuilt.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) disown(changes.rebuilt[i]);
  });
  for (const std::uint32_t pair : changes.new_pairs) ledger_.owner[pair / 2] = none;
  if (marks_[0] != untouched) visit(0, 0);
  derive_fresh();
  release_detached();
  return std::move(remade_);
}

template <int W>
void WideUpdate<W>::disown(std::uint32_t binary) {
  std::vector<std::uint32_t> open{binary};
  while (!open.empty()) {
    const Node& node = bvh_.nodes[open.back()];
    open.pop_back();
    if (node.leaf()) continue;
    ledger_.owner[node.first / 2] = fresh;
    open.push_back(node.first);
    open.push_back(node.first + 1);
  }
}

/// The wide node that holds this pair has changed. Marks one too many for a pair that has been
/// somewhere else before, which does no harm.
template <int W>
void WideUpdate<W>::mark_dirty(std::uint32_t pair) {
  std::uint32_t wide = ledger_.owner[pair];
  if (wide >= nodes_.size() || ledger_.root[wide] == none) return;
  const Mark before = marks_[wide];
  marks_[wide] = dirty;
  if (before != untouched) return;
  for (wide = ledger_.parent[wide]; wide != none && marks_[wide] == untouched;
       wide = ledger_.parent[wide])
    marks_[wide] = on_path;
}

template <int W>
void WideUpdate<W>::visit(std::uint32_t wide, std::uint32_t binary) {
  if (marks_[wide] == dirty) remake(wide, binary);
  for (int i = 0; i < W; ++i) {
    // Nodes may move while the children are visited.
    WideNode<W>& node = nodes_[wide];
    const std::uint32_t child = node.child[i];
    if (child == WideChild::none) continue;
    node.set_box(i, bvh_.nodes[node.source[i]]);
    if (!WideChild::is_leaf(child) && marks_[child] != untouched) visit(child, node.source[i]);
  }
}

template <int W>
void WideUpdate<W>::remake(std::uint32_t wide, std::uint32_t binary) {
  remade_.push_back(wide);
  detach_children(wide);
  ledger_.root[wide] = none;
  Treelet<W> treelet(binary);
  if (!bvh_.nodes[binary].leaf()) treelet.open(bvh_, 0);
  treelet.open_largest(bvh_, [&](std::uint32_t slot) { return rooted(slot) == none; });
  absorb(treelet);
  fill_slots(bvh_, treelet, nodes_[wide]);
  ledger_.root[wide] = treelet.root_pair();
  link(wide, treelet);
}

template <int W>
void WideUpdate<W>::detach_children(std::uint32_t wide) {
  for (const std::uint32_t child : nodes_[wide].child) {
    if (WideChild::is_leaf(child) || ledger_.parent[child] != wide) continue;
    ledger_.parent[child] = none;
    detached_.push_back(child);
  }
}

/// Takes in wide nodes that fit as a whole, of largest area first.
template <int W>
void WideUpdate<W>::absorb(Treelet<W>& treelet) {
  for (;;) {
    std::uint32_t best = W;
    double best_area = -1.0;
    for (std::uint32_t i = 0; i < treelet.count; ++i) {
      const Node& node = bvh_.nodes[treelet.slots[i]];
      const std::uint32_t wide = node.leaf() ? none : rooted(treelet.slots[i]);
      if (wide == none || marks_[wide] == dirty) continue;
      const auto& child = nodes_[wide].child;
      const auto count = std::uint32_t(std::find(child, child + W, WideChild::none) - child);
      const double area = half_area(node.bounds());
      if (treelet.count + count - 1 > W || area <= best_area) continue;
      best = i;
      best_area = area;
    }
    if (best == W) return;
    const std::uint32_t taken = rooted(treelet.slots[best]);
    ledger_.root[taken] = none;
    ledger_.parent[taken] = none;
    detached_.push_back(taken);
    treelet.open(bvh_, best);
    treelet.open_largest(bvh_, [&](std::uint32_t slot) {
      return ledger_.owner[bvh_.nodes[slot].first / 2] == taken;
    });
  }
}

/// Connects the slots of a treelet to the wide nodes below it, those that are there already and
/// new ones.
template <int W>
void WideUpdate<W>::link(std::uint32_t wide, const Treelet<W>& treelet) {
  for (std::uint32_t i = 0; i + 1 < treelet.count; ++i) ledger_.owner[treelet.opened[i] / 2] = wide;
  for (std::uint32_t i = 0; i < treelet.count; ++i) {
    const Node& node = bvh_.nodes[treelet.slots[i]];
    if (node.leaf()) continue;
    std::uint32_t child = rooted(treelet.slots[i]);
    if (child == none && ledger_.owner[node.first / 2] == fresh) {
      fresh_.push_back({wide, i, treelet.slots[i]});
      continue;
    }
    if (child == none) {
      child = allocate();
      marks_[child] = dirty;
    }
    nodes_[wide].child[i] = child;
    ledger_.parent[child] = wide;
  }
}

template <int W>
std::uint32_t WideUpdate<W>::allocate() {
  if (!ledger_.free.empty()) {
    const std::uint32_t wide = ledger_.free.back();
    ledger_.free.pop_back();
    return wide;
  }
  const auto wide = std::uint32_t(nodes_.size());
  WideTarget<W>{nodes_, ledger_}.resize(wide + 1);
  std::fill_n(nodes_[wide].child, W, WideChild::none);
  marks_.push_back(untouched);
  return wide;
}

/// New subtrees of the binary tree, each as a task of its own.
template <int W>
void WideUpdate<W>::derive_fresh() {
  std::vector<WidePart<W>> parts(fresh_.size());
  executor_.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) parts[i].derive(bvh_, fresh_[i].binary);
  });
  std::vector<std::vector<std::uint32_t>> places(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    places[i].resize(parts[i].items.size());
    for (std::uint32_t& place : places[i]) place = allocate();
    nodes_[fresh_[i].wide].child[fresh_[i].slot] = places[i][0];
    ledger_.parent[places[i][0]] = fresh_[i].wide;
    remade_.insert(remade_.end(), places[i].begin(), places[i].end());
  }
  executor_.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      place_part(bvh_, parts[i], WideTarget<W>{nodes_, ledger_},
                 [&](std::size_t n) { return places[i][n]; });
  });
}

/// Frees what has lost its parent and has found no other, with all that only hangs on it.
template <int W>
void WideUpdate<W>::release_detached() {
  while (!detached_.empty()) {
    const std::uint32_t wide = detached_.back();
    detached_.pop_back();
    if (ledger_.parent[wide] != none || marks_[wide] == released) continue;
    marks_[wide] = released;
    detach_children(wide);
    std::fill_n(nodes_[wide].child, W, WideChild::none);
    ledger_.root[wide] = none;
    ledger_.free.push_back(wide);
  }
}

template class WideUpdate<4>;
template class WideUpdate<8>;

}  // namespace regraft::bvh
