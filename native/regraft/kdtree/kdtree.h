#pragma once

#include <span>

#include "regraft/core/executor.h"
#include "regraft/kdtree/node.h"
#include "regraft/kdtree/node_pool.h"
#include "regraft/kdtree/seeded_builder.h"

namespace regraft::kdtree {

/// A k-d tree over the primitives of a scene that builds itself where rays go (Hunt, Mark, Fussell
/// 2007). Which nodes are built depends on the rays alone, and what they become on the scene alone:
/// neither on the threads nor on the order in which these come.
class KdTree {
 public:
  /// Lazy: only the root exists. Otherwise everything is built, on all threads.
  /// `view` must outlive the tree and stay as it is, but for what `invalidate` is told of.
  KdTree(const HierarchyView& view, const Config& config, Executor& executor);
  ~KdTree();
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  Node& root() const { return *root_; }
  const Aabb& bounds() const { return builder_.bounds(); }
  const SeededBuilder& builder() const { return builder_; }
  const HierarchyView& view() const { return view_; }
  const Config& config() const { return builder_.config(); }

  /// Returns when the node is built: by this thread, or by another that was first. To be called
  /// from any number of threads at once. If building throws, the node is unbuilt again.
  void expand(Node& node) const;

  /// Builds all that is not built yet.
  void complete(Executor& executor) const;

  /// Forgets what was built of cells that meet one of `regions`: the only ones in which the view
  /// is not what it was. Planes outside stay. Not while rays are traced.
  void invalidate(std::span<const Aabb> regions);
  /// Nodes built and since forgotten: their memory is only given back with the tree.
  std::uint64_t forgotten() const { return forgotten_; }
  /// Nodes there ever were, unbuilt ones too.
  std::uint64_t made() const { return made_.load(std::memory_order_relaxed); }

  /// Nodes, references and what waits to be built.
  std::size_t bytes() const;
  /// Primitives that wait in unbuilt nodes; those in several count as often.
  double pending_weight() const { return double(pending_weight_.load(std::memory_order_relaxed)); }

 private:
  Pending* keep(Pending&& pending) const;
  void forget(const Pending* pending) const;
  Node* allocate_pair() const;
  void publish(Node& node, Built&& built) const;
  void publish_leaf(Node& node, std::span<const PrimRef> prims) const;
  void build_below(Node& node) const;

  struct Cell {
    Node* node;
    Aabb voxel;
    std::uint32_t depth;
  };
  void invalidate(const Cell& cell, std::span<const Aabb> regions);
  void renew(const Cell& cell);

  const HierarchyView& view_;
  SeededBuilder builder_;
  /// Grows while rays are traced.
  mutable NodePool pool_;
  mutable std::atomic<std::int64_t> pending_bytes_{0};
  mutable std::atomic<std::int64_t> pending_weight_{0};
  mutable std::atomic<std::uint64_t> made_{0};
  std::uint64_t forgotten_ = 0;
  Node* root_;
};

}  // namespace regraft::kdtree
