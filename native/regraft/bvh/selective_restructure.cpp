#include "regraft/bvh/selective_restructure.h"

#include <algorithm>
#include <unordered_set>

#include "regraft/bvh/pair_refinement.h"

namespace regraft::bvh {

namespace {

/// Pairs already chosen: nothing in them or above them may be chosen again.
class Chosen {
 public:
  explicit Chosen(const LivingBvh& tree) : tree_(tree) {}

  bool free(const NodePair& pair) const { return free(pair.a) && free(pair.b); }

  void take(const NodePair& pair) {
    for (std::uint32_t n : {pair.a, pair.b}) {
      taken_.insert(n);
      while (n != 0 && above_.insert(n).second) n = tree_.parent(n);
    }
  }

 private:
  bool free(std::uint32_t n) const {
    if (above_.contains(n)) return false;
    while (n != 0) {
      if (taken_.contains(n)) return false;
      n = tree_.parent(n);
    }
    return true;
  }

  const LivingBvh& tree_;
  std::unordered_set<std::uint32_t> taken_;
  std::unordered_set<std::uint32_t> above_;
};

/// Pairs that are worth more than all that could be done by their refinements, those of largest
/// gain first. A pair's total holds its refinements' benefit, so its gain alone would always beat
/// theirs: damage in two far corners of a scene would be mended by rebuilding all between them. Nor
/// is a pair that costs more than the budget chosen: its refinements are.
std::vector<std::uint32_t> candidates(const LivingBvh& tree, const std::vector<NodePair>& pairs,
                                      double budget) {
  std::vector<double> below(pairs.size(), 0.0);
  std::vector<double> gain(pairs.size(), 0.0);
  std::vector<std::uint8_t> preferred(pairs.size(), 0);
  for (std::size_t i = pairs.size(); i-- > 0;) {
    const NodePair& pair = pairs[i];
    if (tree.damaged(pair.ancestor) && pair.cost <= budget) gain[i] = pair.total - pair.cost;
    preferred[i] = gain[i] > 0.0 && gain[i] >= below[i];
    if (pair.parent != NodePair::none) below[pair.parent] += std::max(gain[i], below[i]);
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < pairs.size(); ++i)
    if (preferred[i] != 0) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return gain[i] != gain[j] ? gain[i] > gain[j] : i < j;
  });
  return order;
}

/// The pairs to restructure, best first, within a budget; their costs together in `cost`.
std::vector<NodePair> choose(const LivingBvh& tree, const std::vector<NodePair>& pairs,
                             double budget, double& cost) {
  Chosen chosen(tree);
  std::vector<NodePair> result;
  cost = 0.0;
  for (const std::uint32_t i : candidates(tree, pairs, budget)) {
    if (cost + pairs[i].cost > budget || !chosen.free(pairs[i])) continue;
    chosen.take(pairs[i]);
    result.push_back(pairs[i]);
    cost += pairs[i].cost;
  }
  return result;
}

}  // namespace

void regraft_all(LivingBvh& tree, const std::vector<NodePair>& pairs, const PrimBoxes& boxes,
                 const BinnedSahBuilder::Config& builder, Executor& executor,
                 RestructureResult& result) {
  std::vector<Graft> grafts(pairs.size());
  executor.parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      grafts[i] = prepare_graft({tree, pairs[i], boxes, builder}, executor);
  });
  result.rebuild_instead =
      std::any_of(grafts.begin(), grafts.end(), [](const Graft& graft) { return !graft.possible; });
  for (std::size_t i = 0; i < grafts.size() && !result.rebuild_instead; ++i) {
    const double saving = std::max(grafts[i].saving, 0.0) / tree.area(0);
    if (saving > 0.0) {
      const std::vector<std::uint32_t> made = apply_graft(tree, grafts[i], pairs[i].ancestor);
      result.nodes_rebuilt += made.size();
      result.replaced.insert(result.replaced.end(), made.begin(), made.end());
    } else {
      accept_damage(tree, pairs[i]);
    }
    result.operations.push_back({pairs[i].total, saving});
  }
}

RestructureResult restructure(LivingBvh& tree, const PrimBoxes& boxes, const Outlook& outlook,
                              const RestructureConfig& config,
                              const BinnedSahBuilder::Config& builder, Executor& executor) {
  RestructureResult result;
  const double weight = outlook.rays * outlook.frames * outlook.yield;
  if (tree.bvh.empty() || tree.bvh.nodes[0].leaf() || !(weight > 0.0)) return result;
  const RestructuringBenefit metric(tree, config, weight);
  const std::vector<NodePair> pairs = refine_pairs(tree, metric, config);
  result.pairs_considered = pairs.size();
  double cost = 0.0;
  std::vector<NodePair> chosen = choose(tree, pairs, std::numeric_limits<double>::infinity(), cost);
  if (!chosen.empty() && cost >= metric.rebuild_cost(tree.prims(0))) {
    result.rebuild_instead = true;
    return result;
  }
  if (cost > outlook.budget) {
    const std::size_t wanted = chosen.size();
    chosen = choose(tree, pairs, outlook.budget, cost);
    // Refinements that take the place of a pair may be more than there were.
    result.pairs_deferred = std::max<std::size_t>(wanted, chosen.size() + 1) - chosen.size();
  }
  regraft_all(tree, chosen, boxes, builder, executor, result);
  for (Restructured& operation : result.operations) operation.predicted *= outlook.yield / weight;
  return result;
}

}  // namespace regraft::bvh
