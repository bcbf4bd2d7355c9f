#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "regraft/bvh/bvh.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// What a slot of a wide node refers to, in 32 bits: an inner node's index, or a leaf's range of
/// `Bvh::prim_ids`.
struct WideChild {
  static constexpr std::uint32_t leaf_bit = 0x80000000u;
  static constexpr std::uint32_t none = 0xFFFFFFFFu;
  static constexpr std::uint32_t begin_bits = 27;
  /// Leaves can start no later: trees over more primitives have no wide layout.
  static constexpr std::uint32_t max_begin = (1u << begin_bits) - 1;

  static std::uint32_t leaf(std::uint32_t begin, std::uint32_t count) {
    return leaf_bit | (count - 1) << begin_bits | begin;
  }
  static bool is_leaf(std::uint32_t child) { return (child & leaf_bit) != 0; }
  static std::uint32_t begin(std::uint32_t child) { return child & max_begin; }
  static std::uint32_t count(std::uint32_t child) { return (child >> begin_bits & 15u) + 1; }
};

/// A node with the boxes of up to W children side by side. `bounds[k]` are the lower and
/// `bounds[3 + k]` the upper planes on axis k. Unused slots come last, have empty boxes and
/// child `none`.
template <int W>
struct alignas(64) WideNode {
  float bounds[6][W];
  std::uint32_t child[W];
  /// The binary node behind each slot, from which a refit takes the box.
  std::uint32_t source[W];

  void set_box(int slot, const Node& box) {
    for (int k = 0; k < 3; ++k) {
      bounds[k][slot] = box.lo[k];
      bounds[3 + k][slot] = box.hi[k];
    }
  }
};

/// Where the nodes of a binary tree are in its wide layout: what a partial update goes by. An
/// inner node is known by its pair of children, which it keeps when nodes change places.
struct WideLedger {
  static constexpr std::uint32_t none = 0xFFFFFFFFu;
  /// Per pair of binary nodes: the wide node that it is in, as slots or opened.
  std::vector<std::uint32_t> owner;
  /// Per wide node: the pair's first node of the binary node it stands for; `none` while free.
  std::vector<std::uint32_t> root;
  std::vector<std::uint32_t> parent;
  /// Wide nodes that are not in use.
  std::vector<std::uint32_t> free;

  std::size_t bytes() const {
    return (owner.capacity() + root.capacity() + parent.capacity() + free.capacity()) *
           sizeof(std::uint32_t);
  }
};

/// What an update did to the shape of a binary tree.
struct Reshaping {
  /// Nodes below which everything is new, and still is where it was built.
  std::vector<std::uint32_t> rebuilt;
  /// Nodes that hold what another node held, and leaves that hold other primitives.
  std::vector<std::uint32_t> replaced;
  /// First nodes of pairs that are new, or used again, above what is not new.
  std::vector<std::uint32_t> new_pairs;
};

/// The layout that rays traverse (Wald, Benthin, Boulos, Getting Rid of Packets, RT 2008):
/// derived from a binary tree, never edited by builders. Node 0 is the root.
class WideBvh {
 public:
  /// Collapses the binary tree: the child of largest area is opened until `width` (4 or 8) slots
  /// are full. Same layout for any number of threads.
  static WideBvh derive(const Bvh& bvh, int width, Executor& executor);

  /// Takes over the boxes of the binary tree, whose shape must be the one last seen.
  void refit(const Bvh& bvh, Executor& executor);

  /// Takes over the boxes of these pairs of binary nodes only: all in which a box changed, and all
  /// above each of them, every one once.
  void refit(const Bvh& bvh, std::span<const std::uint32_t> pairs, Executor& executor);

  /// Derives anew what `changes` reached, with the boxes on the way there; everything else stays
  /// where it is, and keeps its boxes. Time grows with what changed, not with the tree. Same
  /// layout for any number of threads.
  void update(const Bvh& bvh, const Reshaping& changes, Executor& executor);

  /// What rays marked, by wide node, as marks by pair of binary nodes: of pairs in the same wide
  /// node, some of which were collapsed into it, either all are marked or none.
  void spread_marks(std::span<const std::uint8_t> marks, std::span<std::uint8_t> pairs,
                    Executor& executor) const;

  /// The same where `known` holds the marks of the last time by wide node, 2 where it does not say:
  /// only what differs is looked at. Pairs that change are appended to `changed`.
  void spread_marks(std::span<const std::uint8_t> marks, std::span<std::uint8_t> known,
                    std::span<std::uint8_t> pairs, const Bvh& bvh,
                    std::vector<std::uint32_t>& changed) const;

  /// The wide nodes that `update` derived anew the last time; all if it was asked for the root.
  std::span<const std::uint32_t> remade() const { return remade_; }

  int width() const { return width_; }
  std::size_t node_count() const { return width_ == 8 ? nodes8_.size() : nodes4_.size(); }
  /// Nodes among them that hold nothing at present; their first child is `none`.
  std::size_t free_count() const { return ledger_.free.size(); }
  bool empty() const { return node_count() == 0; }
  std::size_t bytes() const {
    return nodes4_.capacity() * sizeof(WideNode<4>) + nodes8_.capacity() * sizeof(WideNode<8>) +
           ledger_.bytes() + remade_.capacity() * sizeof(std::uint32_t);
  }
  template <int W>
  const WideNode<W>* nodes() const;

 private:
  int width_ = 8;
  AlignedVector<WideNode<4>> nodes4_;
  AlignedVector<WideNode<8>> nodes8_;
  WideLedger ledger_;
  std::vector<std::uint32_t> remade_;
};

template <>
inline const WideNode<4>* WideBvh::nodes<4>() const {
  return nodes4_.data();
}
template <>
inline const WideNode<8>* WideBvh::nodes<8>() const {
  return nodes8_.data();
}

}  // namespace regraft::bvh
