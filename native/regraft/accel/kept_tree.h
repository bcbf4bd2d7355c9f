#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "regraft/accel/crown_schedule.h"
#include "regraft/accel/mending_budget.h"
#include "regraft/accel/motion.h"
#include "regraft/accel/ray_ledger.h"
#include "regraft/accel/ray_marks.h"
#include "regraft/accel/update_policy.h"
#include "regraft/bvh/edit.h"
#include "regraft/bvh/local_refit.h"
#include "regraft/bvh/selective_restructure.h"
#include "regraft/bvh/wide_bvh.h"
#include "regraft/core/executor.h"

namespace regraft::accel {

/// What one tree's update did.
struct TreeWork {
  TreeUpdate done = TreeUpdate::none;
  std::uint64_t nodes_refitted = 0;
  std::uint64_t nodes_rebuilt = 0;
  std::uint64_t pairs_considered = 0;
  std::uint64_t pairs_deferred = 0;  ///< worth mending, but left for the next update
  std::uint64_t edited = 0;  ///< primitives put in or taken out without building a tree anew
  /// Tried pairs: expected tests of a frame that were to be saved, and that were.
  std::vector<bvh::Restructured> operations;
  double select_ms = 0.0;

  void add(const TreeWork& other);
};

/// What a tree is built over.
struct Primitives {
  std::span<const Aabb> boxes;         ///< of each by its id
  std::span<const std::uint32_t> ids;  ///< those that are in the tree
  bvh::BinnedSahBuilder::Config builder;
  /// By key frame of the shot, where the policy plans for all of it.
  std::span<const std::vector<Aabb>> key_boxes;
};

/// A binary tree kept alive from frame to frame by any policy, with the wide layout that rays
/// traverse: the part that trees of meshes and the top tree share. Holds no geometry: boxes come
/// with each call.
class KeptTree {
 public:
  /// What is to be done before anything is measured; see `choose_update`.
  TreeUpdate choose(bool topology_changed, bool moved, const Tending& how) const;

  /// Builds the tree anew.
  void build(const Primitives& prims, const Tending& how, Executor& executor);

  /// Follows the motion of the primitives, where few moved only above these.
  template <bvh::PrimitiveBounds F>
  void refit(const F& bounds, const Motion& motion, const Tending& how, Executor& executor) {
    measure_if_asked(how, executor);
    is_local_ = touch(motion, how, executor);
    if (is_local_)
      now_ = local_.run(tree_, bounds, executor);
    else if (is_measured_)
      now_ = bvh::refit(tree_, bounds, executor);
    else
      now_ = bvh::refit(tree_.bvh, bounds, executor);
  }

  /// After `refit`: what the policy says of the tree as it is now is done, but for rebuilding it,
  /// which is left to the caller. `work` receives what was done.
  void mend(const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
            const Tending& how, Executor& executor, TreeWork& work);

  /// Takes primitives out of the tree and puts others in, `count` in all, unless that makes more
  /// than three tenths since the last build or the policy builds whole trees; those that stay may
  /// have moved. @return false if the tree is to be built anew instead.
  bool edit(const bvh::PrimitiveEdit& change, std::size_t count, const bvh::PrimBoxes& boxes,
            const bvh::BinnedSahBuilder::Config& builder, const Tending& how, Executor& executor,
            TreeWork& work);

  /// Expected tests of a ray that enters each primitive, where it is not that of a triangle.
  void set_prim_costs(std::vector<double> costs) { tree_.prim_costs = std::move(costs); }

  bool exists() const { return exists_; }
  /// Excess cost of a node as a share of what it costs.
  double damage(std::uint32_t node) const;
  /// The nodes that `update` made anew, in no order; the root alone if it was all of them.
  std::span<const std::uint32_t> made_in(std::uint64_t update) const {
    return shaped_in_ == update ? std::span<const std::uint32_t>(made_)
                                : std::span<const std::uint32_t>();
  }
  /// The node above `node`, which is not the root; the root where nothing is measured.
  std::uint32_t parent(std::uint32_t node) const {
    return tree_.measured() ? tree_.parent(node) : 0;
  }
  const bvh::Bvh& bvh() const { return tree_.bvh; }
  int width() const { return wide_.width(); }
  /// bvh::WideNode<width>[]; null for the empty tree.
  const void* wide_nodes() const;
  /// Where rays mark the wide nodes that they enter; read by the next `refit`.
  std::uint8_t* entered() const { return marks_.entered(); }
  /// Whether any entered since the last `refit` or `build`.
  bool was_entered() const { return marks_.any(); }
  /// Where sampled rays count the nodes and triangles that they visit.
  std::uint64_t* work() const { return work_.data(); }
  /// That count since it was last taken.
  std::uint64_t take_work() { return std::exchange(work_[0], 0); }
  Aabb bounds() const { return tree_.bvh.bounds(); }
  double sah_cost() const { return now_.sah_cost; }
  /// C(root), of what rays entered of late if the tree is measured.
  double culling_efficiency() const {
    return tree_.measured() && !tree_.bvh.empty() ? tree_.cost(0) : now_.sah_cost;
  }
  double wear() const { return now_.wear(built_); }
  std::size_t bytes() const;

 private:
  /// What predictions are trusted at first: about what operations realise on average.
  static constexpr double first_yield = 0.25;

  bool builds_quickly(std::size_t prims, const Tending& how) const;
  bvh::Bvh built(const Primitives& prims, const Tending& how, Executor& executor) const;
  void measure_if_asked(const Tending& how, Executor& executor);
  bool touch(const Motion& motion, const Tending& how, Executor& executor);
  void reshape(bvh::Reshaping& changes, const Tending& how, Executor& executor);
  TreeState state(const Tending& how, Executor& executor) const;
  void restructure(const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
                   const Tending& how, Executor& executor, TreeWork& work, bvh::Reshaping& changes);
  bvh::RestructureConfig within_budget(bvh::RestructureConfig costs) const;
  double lost_tests() const;
  void tend_crown(const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
                  const Tending& how, Executor& executor, bvh::RestructureResult& result);
  void learn(const std::vector<bvh::Restructured>& operations);
  double rebuild_promise(double tests) const;

  bvh::LivingBvh tree_;
  bvh::WideBvh wide_;
  RayMarks marks_;
  bvh::LocalRefit local_;
  bool is_local_ = false;     ///< the last refit went by single primitives
  bool is_measured_ = false;  ///< metrics are those of the present boxes
  /// One number, in memory of its own: rays write to it while trees are moved about.
  mutable std::vector<std::uint64_t> work_ = {0};
  bvh::RefitResult now_;
  bvh::RefitResult built_;
  bvh::LifeTime life_;
  /// Realised over predicted savings, of restructuring and of rebuilding.
  double yield_ = first_yield;
  double rebuild_yield_ = 0.5;
  /// The tree's cost before a rebuild that is due, and what the rebuild is to save of it.
  struct {
    double cost = 0.0;
    double predicted = 0.0;
  } promise_;
  RayLedger rays_;
  std::vector<std::uint32_t> made_;  ///< nodes of the last change of shape
  std::uint64_t shaped_in_ = 0;      ///< the update that did it
  CrownSchedule crown_;
  MendingBudget budget_;
  double ratio_sum_ = 0.0;  ///< of the last build; for `rtdeform`
  Habit habit_;
  Look look_;                      ///< of this update
  double looseness_seen_ = 0.0;    ///< when the tree was last measured
  std::uint32_t since_build_ = 0;  ///< updates
  std::size_t edited_ = 0;         ///< primitives that came or went since the build
  bool exists_ = false;
};

}  // namespace regraft::accel
