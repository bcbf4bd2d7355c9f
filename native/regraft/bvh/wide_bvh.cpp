#include "regraft/bvh/wide_bvh.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <numeric>

#include "regraft/bvh/wide_update.h"

namespace regraft::bvh {

namespace {

/// The top serially, the subtrees below it as tasks of their own, joined in order.
template <int W>
void collapse(const Bvh& bvh, const WideTarget<W>& target, Executor& executor) {
  constexpr std::size_t tasks = 64;
  grow(target.ledger.owner, bvh.nodes.size() / 2, WideLedger::none);
  target.ledger.owner[0] = 0;
  WidePart<W> top;
  top.derive_top(bvh, tasks);
  const std::uint32_t top_count = std::uint32_t(top.items.size());
  std::vector<WidePart<W>> parts(top.open.size());
  executor.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) parts[i].derive(bvh, top.open[i].binary);
  });
  std::vector<std::uint32_t> offsets(parts.size());
  std::size_t total = top_count;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    offsets[i] = std::uint32_t(total);
    total += parts[i].items.size();
  }
  target.resize(total);
  place_part(bvh, top, target,
             [&](std::uint32_t n) { return n < top_count ? n : offsets[n - top_count]; });
  executor.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      place_part(bvh, parts[i], target, [&](std::uint32_t n) { return offsets[i] + n; });
  });
}

template <int W>
void take_boxes(const Bvh& bvh, AlignedVector<WideNode<W>>& nodes, Executor& executor) {
  executor.parallel_for(nodes.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) gather_boxes(bvh, nodes[n]);
  });
}

/// A wide node is found by the topmost of its pairs, so that only one task writes to it.
template <int W>
void take_boxes_of(const Bvh& bvh, std::span<const std::uint32_t> pairs,
                   const WideTarget<W>& target, Executor& executor) {
  executor.parallel_for(pairs.size(), 2048, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t wide = target.ledger.owner[pairs[k]];
      if (wide < target.nodes.size() && target.ledger.root[wide] == 2 * pairs[k])
        gather_boxes(bvh, target.nodes[wide]);
    }
  });
}

/// Sets the marks of all pairs of wide node `wide` from pair `pair` downwards.
void spread_mark(const Bvh& bvh, const WideLedger& ledger, std::uint32_t wide, std::uint32_t pair,
                 std::uint8_t mark, std::span<std::uint8_t> pairs,
                 std::vector<std::uint32_t>& changed) {
  if (pairs[pair] != mark) {
    pairs[pair] = mark;
    changed.push_back(pair);
  }
  for (std::uint32_t n = 2 * pair; n < 2 * pair + 2; ++n) {
    const Node& node = bvh.nodes[n];
    if (!node.leaf() && ledger.owner[node.first >> 1] == wide)
      spread_mark(bvh, ledger, wide, node.first >> 1, mark, pairs, changed);
  }
}

}  // namespace

WideBvh WideBvh::derive(const Bvh& bvh, int width, Executor& executor) {
  assert(width == 4 || width == 8);
  WideBvh wide;
  wide.width_ = width;
  if (bvh.empty()) return wide;
  if (width == 8)
    collapse<8>(bvh, {wide.nodes8_, wide.ledger_}, executor);
  else
    collapse<4>(bvh, {wide.nodes4_, wide.ledger_}, executor);
  return wide;
}

void WideBvh::refit(const Bvh& bvh, Executor& executor) {
  if (width_ == 8)
    take_boxes<8>(bvh, nodes8_, executor);
  else
    take_boxes<4>(bvh, nodes4_, executor);
}

void WideBvh::refit(const Bvh& bvh, std::span<const std::uint32_t> pairs, Executor& executor) {
  if (width_ == 8)
    take_boxes_of<8>(bvh, pairs, {nodes8_, ledger_}, executor);
  else
    take_boxes_of<4>(bvh, pairs, {nodes4_, ledger_}, executor);
}

void WideBvh::spread_marks(std::span<const std::uint8_t> marks, std::span<std::uint8_t> pairs,
                           Executor& executor) const {
  executor.parallel_for(pairs.size(), 32768, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t wide = ledger_.owner[i];
      pairs[i] = wide < marks.size() ? marks[wide] : 0;
    }
  });
}

void WideBvh::spread_marks(std::span<const std::uint8_t> marks, std::span<std::uint8_t> known,
                           std::span<std::uint8_t> pairs, const Bvh& bvh,
                           std::vector<std::uint32_t>& changed) const {
  constexpr std::size_t line = 64;
  for (std::size_t begin = 0; begin < marks.size(); begin += line) {
    const std::size_t end = std::min(begin + line, marks.size());
    if (std::memcmp(&marks[begin], &known[begin], end - begin) == 0) continue;
    for (std::size_t wide = begin; wide < end; ++wide) {
      const std::uint32_t first = ledger_.root[wide];
      if (marks[wide] != known[wide] && first != WideLedger::none && first != 0)
        spread_mark(bvh, ledger_, std::uint32_t(wide), first >> 1, marks[wide], pairs, changed);
      known[wide] = marks[wide];
    }
  }
}

void WideBvh::update(const Bvh& bvh, const Reshaping& changes, Executor& executor) {
  const bool everything =
      std::find(changes.rebuilt.begin(), changes.rebuilt.end(), 0u) != changes.rebuilt.end();
  if (everything || empty() || bvh.empty()) {
    *this = derive(bvh, width_, executor);
    remade_.resize(node_count());
    std::iota(remade_.begin(), remade_.end(), 0u);
    return;
  }
  if (width_ == 8)
    remade_ = WideUpdate<8>(bvh, {nodes8_, ledger_}, executor).run(changes);
  else
    remade_ = WideUpdate<4>(bvh, {nodes4_, ledger_}, executor).run(changes);
}

}  // namespace regraft::bvh
