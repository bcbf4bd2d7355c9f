#include "regraft/accel/kept_tree.h"

#include <algorithm>
#include <chrono>

#include "regraft/bvh/crown.h"
#include "regraft/bvh/key_frame_builder.h"
#include "regraft/bvh/morton_builder.h"
#include "regraft/bvh/rotate_living.h"
#include "regraft/bvh/volume_restructure.h"

namespace regraft::accel {

namespace {

/// Predictions are never trusted less than this: what happens next may differ.
constexpr double least_yield = 0.02;
/// Excess below this share of all costs is what rounding makes of a tree that moves as a whole.
constexpr double noise = 1e-4;
/// Parts that the top of a tree is built anew over: one for so many primitives, within limits.
constexpr std::uint32_t crown_share = 16;
constexpr std::uint32_t least_parts = 512;
constexpr std::uint32_t most_parts = 16384;
/// Taking the top apart, weighing the parts and laying them out anew costs so many times what
/// building over the parts does.
constexpr double crown_cost = 3.0;
/// Tests that a tree along a Morton curve costs more than one by surface area: 3 to 21 %.
constexpr double morton_excess = 0.15;
/// Box tests that measuring a node takes, and building one anew.
constexpr double measure_cost = 2.0;
constexpr double rebuild_cost = 40.0;
/// A tree that has worn by this factor since it was last looked at is looked at again.
constexpr double alarming = 1.05;
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
  pairs_deferred += other.pairs_deferred;
  edited += other.edited;
  operations.insert(operations.end(), other.operations.begin(), other.operations.end());
  select_ms += other.select_ms;
}

TreeUpdate KeptTree::choose(bool topology_changed, bool moved, const Tending& how) const {
  TreeState state;
  // There is nothing to mend in a tree of nothing.
  state.exists = exists_ && tree_.bvh.node_count() > 0;
  state.topology_changed = topology_changed || wide_.width() != how.width;
  state.moved = moved;
  state.habit = habit_;
  return choose_update(state, how.policy);
}

bvh::Bvh KeptTree::built(const Primitives& prims, const Tending& how, Executor& executor) const {
  if (!prims.key_boxes.empty()) {
    const std::vector<std::span<const Aabb>> frames(prims.key_boxes.begin(), prims.key_boxes.end());
    bvh::KeyFrameBuilder::Config config;
    config.max_leaf = prims.builder.max_leaf;
    return bvh::KeyFrameBuilder::build(frames, prims.ids, config, executor);
  }
  if (builds_quickly(prims.ids.size(), how))
    return bvh::MortonBuilder::build(prims.boxes, prims.ids, {prims.builder.max_leaf}, executor);
  return bvh::BinnedSahBuilder::build(prims.boxes, prims.ids, prims.builder, executor);
}

/// What is built anew every frame is not worth the dearer builder: `auto` takes the quick one if
/// the tests it costs until the next build are fewer than what it saves.
bool KeptTree::builds_quickly(std::size_t prims, const Tending& how) const {
  if (how.policy != Policy::automatic || !exists_) return false;
  const double lasting = std::min(life_.frames(how.frames_left), 1.0 + double(since_build_));
  const double worse = how.rays * lasting * now_.sah_cost / now_.wear(built_) * morton_excess;
  return worse + how.costs.morton * double(prims) <
         how.costs.rebuild * double(prims) * std::log2(double(std::max<std::size_t>(prims, 2)));
}

void KeptTree::build(const Primitives& prims, const Tending& how, Executor& executor) {
  tree_.bvh = built(prims, how, executor);
  tree_.stop_measuring();
  tree_.model.leaf = how.costs.leaf;
  now_ = built_ = bvh::assess(
      tree_.bvh, [&](std::uint32_t i) { return bvh::Box4(prims.boxes[i]); }, executor, tree_.model);
  since_build_ = 0;
  edited_ = 0;
  wide_ = bvh::WideBvh::derive(tree_.bvh, how.width, executor);
  marks_.reset(wide_);
  local_ = {};
  is_measured_ = false;
  measure_if_asked(how, executor);
  life_.count_frame(tree_.bvh.node_count());
  life_.count_built(tree_.bvh.node_count());
  if (promise_.predicted > 0.0)
    rebuild_yield_ =
        blend(rebuild_yield_, promise_.cost - now_.sah_cost, promise_.predicted / rebuild_yield_);
  promise_ = {};
  rays_.begin();
  ratio_sum_ = how.policy == Policy::rtdeform ? bvh::area_ratio_sum(tree_.bvh, executor) : 0.0;
  habit_.note(TreeUpdate::rebuild, {});
  look_ = {};
  looseness_seen_ = now_.looseness;
  made_ = {0};
  shaped_in_ = how.update;
  exists_ = true;
}

double KeptTree::damage(std::uint32_t node) const {
  const double all = tree_.measured() ? tree_.cost(node) * tree_.area(node) : 0.0;
  return all > 0.0 ? tree_.excess(node) / all : 0.0;
}

void KeptTree::measure_if_asked(const Tending& how, Executor& executor) {
  tree_.model.leaf = how.costs.leaf;
  if (!wants_metrics(how.policy, habit_) || tree_.measured()) return;
  tree_.start_measuring(executor);
  is_measured_ = true;
}

/// Notes what a refit has to look at. @return whether that is worth doing node by node; metrics are
/// then taken whoever asks, since only what moved costs anything.
bool KeptTree::touch(const Motion& motion, const Tending& how, Executor& executor) {
  const bool is_small = tree_.bvh.empty() || tree_.bvh.nodes[0].leaf();
  if (motion.all || is_small) {
    local_.forget_sums();
    is_measured_ = tree_.measured() && wants_metrics(how.policy, habit_);
    marks_.tell(wide_, how.traced, tree_, executor);
    return false;
  }
  if (!local_.linked()) local_.link(tree_.bvh, executor);
  if (local_.summed() && is_measured_ == tree_.measured()) {
    std::vector<std::uint32_t> pairs;
    marks_.tell_changes(wide_, how.traced, tree_, pairs);
    for (const std::uint32_t pair : pairs) local_.touch_pair(pair);
    local_.touch_prims(motion.prims, executor);
  } else {
    marks_.tell(wide_, how.traced, tree_, executor);
    local_.touch_all();
  }
  is_measured_ = tree_.measured();
  return true;
}

/// Of `tests` a ray, those that a rebuild is expected to save: what the tree has worn since its
/// build, as far as experience confirms it.
double KeptTree::rebuild_promise(double tests) const {
  const double wear = now_.wear(built_);
  return wear > 1.0 ? rebuild_yield_ * tests * (1.0 - 1.0 / wear) : 0.0;
}

TreeState KeptTree::state(const Tending& how, Executor& executor) const {
  TreeState state;
  state.exists = state.moved = state.refitted = true;
  state.habit = habit_;
  if (how.policy == Policy::rtdeform && ratio_sum_ > 0.0) {
    const double change = bvh::area_ratio_sum(tree_.bvh, executor) / ratio_sum_;
    state.ratio_change = std::max(change, 1.0 / change);
  }
  const double prims = double(tree_.bvh.prim_ids.size());
  state.overpaid = rays_.lost_tests() > how.costs.rebuild * prims * std::log2(std::max(prims, 2.0));
  if (!tree_.measured() || tree_.bvh.empty()) return state;
  const bvh::RestructuringBenefit metric(tree_, how.costs, 1.0);
  state.worth_rebuilding =
      how.rays * life_.frames(how.frames_left) * rebuild_promise(culling_efficiency()) >
      metric.rebuild_cost(tree_.prims(0));
  return state;
}

void KeptTree::mend(const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
                    const Tending& how, Executor& executor, TreeWork& work) {
  work.nodes_refitted += now_.nodes;
  budget_.note_refit(now_.nodes);
  rays_.note(how.work);
  work.done = choose_update(state(how, executor), how.policy);
  bvh::Reshaping changes;
  look_ = {is_measured_ ? measure_cost * double(now_.nodes) : 0.0, 0.0};
  if (work.done == TreeUpdate::restructure)
    restructure(boxes, builder, how, executor, work, changes);
  if (work.done == TreeUpdate::rebuild) {
    promise_ = {now_.sah_cost, rebuild_promise(now_.sah_cost)};
    return;
  }
  reshape(changes, how, executor);
  ++since_build_;
  life_.count_frame(tree_.bvh.node_count());
  life_.count_built(work.nodes_rebuilt);
  habit_.note(work.done, look_);
  if (is_measured_) looseness_seen_ = now_.looseness;
  if (now_.looseness > alarming * looseness_seen_) habit_.alarm();
}

/// Brings the layout that rays traverse, and all that goes by the tree's shape, in line with it.
void KeptTree::reshape(bvh::Reshaping& changes, const Tending& how, Executor& executor) {
  const bool is_reshaped = !changes.replaced.empty();
  if (is_reshaped) wide_.update(tree_.bvh, changes, executor);
  if (is_local_ && !local_.touched_all())
    wide_.refit(tree_.bvh, local_.touched(), executor);
  else
    wide_.refit(tree_.bvh, executor);
  marks_.begin(wide_, is_reshaped);
  if (!is_reshaped) return;
  if (local_.linked()) local_.relink(tree_.bvh, changes.replaced);
  made_ = std::move(changes.replaced);
  shaped_in_ = how.update;
}

void KeptTree::restructure(const bvh::PrimBoxes& boxes,
                           const bvh::BinnedSahBuilder::Config& builder, const Tending& how,
                           Executor& executor, TreeWork& work, bvh::Reshaping& changes) {
  const auto start = std::chrono::steady_clock::now();
  if (how.policy == Policy::selective_rotate) {
    for (const bvh::Rotation& r : bvh::rotate(tree_, executor))
      changes.replaced.insert(changes.replaced.end(), {r.child, r.grandchild});
    if (!changes.replaced.empty()) now_.sah_cost = bvh::sah_cost(tree_.bvh, tree_.model);
  }
  const bvh::Outlook outlook{how.rays, life_.frames(how.frames_left), yield_, budget_.tests()};
  bvh::RestructureResult result =
      how.policy == Policy::lm
          ? bvh::restructure_by_volume(tree_, boxes, builder, executor)
          : bvh::restructure(tree_, boxes, outlook, within_budget(how.costs), builder, executor);
  if (how.policy != Policy::lm && !result.rebuild_instead)
    tend_crown(boxes, builder, how, executor, result);
  work.select_ms +=
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  work.pairs_considered += result.pairs_considered;
  work.pairs_deferred += result.pairs_deferred;
  work.nodes_rebuilt += result.nodes_rebuilt;
  if (how.policy != Policy::lm) learn(result.operations);
  look_.price += how.costs.refine * double(result.pairs_considered) +
                 rebuild_cost * double(result.nodes_rebuilt);
  look_.gain += how.rays * result.crown_saving;
  for (bvh::Restructured& operation : result.operations) {
    now_.sah_cost -= operation.realised;
    operation.predicted *= how.rays;
    operation.realised *= how.rays;
    look_.gain += operation.realised;
  }
  work.operations.insert(work.operations.end(), result.operations.begin(), result.operations.end());
  changes.replaced.insert(changes.replaced.end(), result.replaced.begin(), result.replaced.end());
  if (result.rebuild_instead)
    work.done = TreeUpdate::rebuild;
  else if (changes.replaced.empty())
    work.done = TreeUpdate::refit;
}

bvh::RestructureConfig KeptTree::within_budget(bvh::RestructureConfig costs) const {
  costs.pair_limit = std::min(costs.pair_limit, budget_.looks(costs.refine));
  return costs;
}

/// Expected tests of a ray that are due to what was lost since the tree was in order or was built.
double KeptTree::lost_tests() const {
  const double area = tree_.area(0);
  const double wear = now_.wear(built_);
  const double since_build = wear > 1.0 ? tree_.cost(0) * (1.0 - 1.0 / wear) : 0.0;
  return std::max(area > 0.0 ? tree_.excess(0) / area : 0.0, since_build);
}

/// Tries the top of what is damaged anew, if what was lost there could pay for it.
void KeptTree::tend_crown(const bvh::PrimBoxes& boxes, const bvh::BinnedSahBuilder::Config& builder,
                          const Tending& how, Executor& executor, bvh::RestructureResult& result) {
  const double tests = tree_.cost(0);
  if (!(tree_.excess(0) > noise * tests * tree_.area(0))) return;
  const std::uint32_t node = bvh::damaged_part(tree_);
  const std::uint32_t prims = tree_.prims(node);
  std::uint32_t parts = std::min(std::clamp(prims / crown_share, least_parts, most_parts), prims);
  // Where only a part moves, no update takes much longer than the others for its sake.
  if (is_local_) parts = std::min(parts, budget_.looks(8.0 * crown_cost * how.costs.rebuild));
  const double price =
      crown_cost * bvh::RestructuringBenefit(tree_, how.costs, 1.0).rebuild_cost(parts);
  if (!crown_.is_due(how.rays * lost_tests(), price)) return;
  bvh::rebuild_crown(tree_, {node, parts}, boxes, builder, executor, result);
  now_.sah_cost -= result.crown_saving;
  crown_.note(how.rays * result.crown_saving, price);
  // Nothing to be gained at the top: the tree is about as good as one just built.
  if (result.crown_saving < 0.01 * tests) built_.looseness = now_.looseness;
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
  return tree_.bytes() + wide_.bytes() + marks_.bytes() + local_.bytes();
}

}  // namespace regraft::accel
