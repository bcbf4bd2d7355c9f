#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "regraft/bvh/graft.h"

namespace regraft::bvh {

/// What an update knows of rays and frames.
struct Outlook {
  double rays = 0.0;    ///< N_r: rays a frame that hit the root's box
  double frames = 1.0;  ///< Life, Eq. 6
  /// Share of predicted benefits that past operations realised.
  double yield = 1.0;
  /// What operations may cost together, in box tests. What does not fit waits for the next frame.
  double budget = std::numeric_limits<double>::infinity();
};

/// One restructured pair, in expected tests a ray that hits the root's box.
struct Restructured {
  double predicted = 0.0;  ///< total benefit of the pair, scaled by `Outlook::yield`
  double realised = 0.0;   ///< by how much C(root) fell, with everything seen
};

struct RestructureResult {
  std::uint64_t pairs_considered = 0;
  /// Pairs that would have been restructured, had the budget been larger.
  std::uint64_t pairs_deferred = 0;
  std::uint64_t nodes_rebuilt = 0;
  std::vector<Restructured> operations;
  /// By how much building the top anew made C(root) fall, with everything seen.
  double crown_saving = 0.0;
  /// Nodes that now hold something else; those above them may have new boxes.
  std::vector<std::uint32_t> replaced;
  /// Nothing was done: rebuilding the whole tree costs no more than what is worth doing.
  bool rebuild_instead = false;
};

/// Selective restructuring of one frame (Yoon, Curtis, Manocha 2007, section 5): of all pairs that
/// are worth it, those with the largest benefit over cost first, none that touches another, are
/// shared out and built anew.
///
/// The tree is measured and refitted. Deviations: pairs are chosen before any is restructured, so
/// that all are built in parallel, with the same result for any number of threads; subtrees are
/// built at once, since what no ray enters has no benefit and is not chosen.
RestructureResult restructure(LivingBvh& tree, const PrimBoxes& boxes, const Outlook& outlook,
                              const RestructureConfig& config,
                              const BinnedSahBuilder::Config& builder, Executor& executor);

/// Restructures `pairs`, none of which touches another, all at once; says in `result` what came of
/// it. Predictions are the pairs' totals.
void regraft_all(LivingBvh& tree, const std::vector<NodePair>& pairs, const PrimBoxes& boxes,
                 const BinnedSahBuilder::Config& builder, Executor& executor,
                 RestructureResult& result);

}  // namespace regraft::bvh
