#include "regraft/accel/kept_tree.h"

#include <algorithm>
#include <chrono>

#include "regraft/bvh/rotate_living.h"
#include "regraft/bvh/volume_restructure.h"

namespace regraft::accel {

namespace {

/// Predictions are never trusted less than this: what happens next may differ.
constexpr double least_yield = 0.02;
/// How fast a frame in which nothing was tried lets the past be forgotten.
constexpr double forgetting = 0.02;

double blend(double old, double realised, double predicted) {
  return std::clamp(0.5 * old + 0.5 * realised / predicted, least_yield, 1.5);
}

}  // namespace

void TreeWork::add(const TreeWork& other) {
  done = std::max(done, other.done);
  nodes_refitted += other.nodes_refitted;
  nodes_rebuilt += other.nodes_rebuilt;
  pairs_considered += other.pairs_considered;
  operations.insert(operations.end(), other.operations.begin(), other.operations.end());
  select_ms += other.select_ms;
}

TreeUpdate KeptTree::choose(bool topology_changed, bool moved, const Tending& how) const {
  TreeState state;
  state.exists = exists_;
  state.topology_changed = topology_changed || wide_.width() != how.width;
  state.moved = moved;
  state.habit = habit_;
  return choose_update(state, how.policy);
}

void KeptTree::build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
                     const bvh::BinnedSahBuilder::Config& builder, const Tending& how,
                     Executor& executor) {
  tree_.bvh = bvh::BinnedSahBuilder::build(boxes, ids, builder, executor);
  tree_.stop_measuring();
  now_ = built_ = bvh::refit(
      tree_, [&](std::uint32_t i) { return bvh::Box4(boxes[i]); }, executor);
  wide_ = bvh::WideBvh::derive(tree_.bvh, how.width, executor);
  measure_if_asked(how);
  life_.count_frame(tree_.bvh.node_count());
  life_.count_built(tree_.bvh.node_count());
  if (promise_.predicted > 0.0)
    rebuild_yield_ =
        blend(rebuild_yield_, promise_.cost - now_.sah_cost, promise_.predicted / rebuild_yield_);
  promise_ = {};
  ratio_sum_ = how.policy == Policy::rtdeform ? bvh::area_ratio_sum(tree_.bvh, executor) : 0.0;
  habit_.note(TreeUpdate::rebuild);
  exists_ = true;
}

void KeptTree::measure_if_asked(const Tending& how) {
  if (wants_metrics(how.policy, habit_) && !tree_.measured()) tree_.start_measuring();
}

/// Tests a ray that a rebuild is expected to save: what the tree has worn since its build, as far
/// as experience confirms it.
double KeptTree::rebuild_promise() const {
  const double wear = now_.wear(built_);
  return wear > 1.0 ? rebuild_yield_ * now_.sah_cost * (1.0 - 1.0 / wear) : 0.0;
}

TreeState KeptTree::state(const Tending& how, Executor& executor) const {
  TreeState state;
  state.exists = state.moved = state.refitted = true;
  state.habit = habit_;
  if (how.policy == Policy::rtdeform && ratio_sum_ > 0.0) {
    const double change = bvh::area_ratio_sum(tree_.bvh, executor) / ratio_sum_;
    state.ratio_change = std::max(change, 1.0 / change);
  }
  if (!tree_.measured() || tree_.bvh.empty()) return state;
  const bvh::RestructuringBenefit metric(tree_, how.costs, 1.0);
  state.worth_rebuilding = how.rays * life_.frames(how.frames_left) * rebuild_promise() >
                           metric.rebuild_cost(tree_.prims(0));
  return state;
}

void KeptTree::mend(const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
                    const Tending& how, Executor& executor, TreeWork& work) {
  work.nodes_refitted += now_.nodes;
  work.done = choose_update(state(how, executor), how.policy);
  bvh::Reshaping changes;
  if (work.done == TreeUpdate::restructure)
    restructure(boxes, builder, how, executor, work, changes);
  if (work.done == TreeUpdate::rebuild) {
    promise_ = {now_.sah_cost, rebuild_promise()};
    return;
  }
  if (!changes.replaced.empty()) {
    wide_.update(tree_.bvh, changes, executor);
    now_.sah_cost = bvh::sah_cost(tree_.bvh);
  }
  wide_.refit(tree_.bvh, executor);
  life_.count_frame(tree_.bvh.node_count());
  life_.count_built(work.nodes_rebuilt);
  habit_.note(work.done);
}

void KeptTree::restructure(const bvh::PrimBoxes& boxes,
                           const bvh::BinnedSahBuilder::Config& builder, const Tending& how,
                           Executor& executor, TreeWork& work, bvh::Reshaping& changes) {
  const auto start = std::chrono::steady_clock::now();
  if (how.policy == Policy::selective_rotate)
    for (const bvh::Rotation& r : bvh::rotate(tree_, executor))
      changes.replaced.insert(changes.replaced.end(), {r.child, r.grandchild});
  const bvh::Outlook outlook{how.rays, life_.frames(how.frames_left), yield_};
  bvh::RestructureResult result =
      how.policy == Policy::lm
          ? bvh::restructure_by_volume(tree_, boxes, builder, executor)
          : bvh::restructure(tree_, boxes, outlook, how.costs, builder, executor);
  work.select_ms +=
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  work.pairs_considered += result.pairs_considered;
  work.nodes_rebuilt += result.nodes_rebuilt;
  if (how.policy != Policy::lm) learn(result.operations);
  for (bvh::Restructured& operation : result.operations) {
    operation.predicted *= how.rays;
    operation.realised *= how.rays;
  }
  work.operations.insert(work.operations.end(), result.operations.begin(), result.operations.end());
  changes.replaced.insert(changes.replaced.end(), result.replaced.begin(), result.replaced.end());
  if (result.rebuild_instead)
    work.done = TreeUpdate::rebuild;
  else if (changes.replaced.empty())
    work.done = TreeUpdate::refit;
}

void KeptTree::learn(const std::vector<bvh::Restructured>& operations) {
  double predicted = 0.0;
  double realised = 0.0;
  for (const bvh::Restructured& operation : operations) {
    predicted += operation.predicted;
    realised += operation.realised;
  }
  if (predicted > 0.0)
    yield_ = blend(yield_, realised, predicted / yield_);
  else
    yield_ += forgetting * (first_yield - yield_);
}

const void* KeptTree::wide_nodes() const {
  if (wide_.empty()) return nullptr;
  return wide_.width() == 8 ? static_cast<const void*>(wide_.nodes<8>())
                            : static_cast<const void*>(wide_.nodes<4>());
}

std::size_t KeptTree::bytes() const {
  return tree_.bytes() + wide_.bytes();
}

}  // namespace regraft::accel
