#pragma once

#include <cstdint>

#include "regraft/bvh/living_bvh.h"

namespace regraft::bvh {

/// What restructuring weighs, in units of one ray/box test; measured where a test takes 14 ns.
struct RestructureConfig {
  /// Rebuilding m primitives costs this times m·log2(m).
  double rebuild = 4.0;
  /// Looking at one pair of nodes.
  double refine = 30.0;
  /// Pairs looked at in one update. Scenes that need more are better rebuilt.
  std::uint32_t pair_limit = 4096;
  /// Building one primitive's share of a tree along a Morton curve.
  double morton = 4.0;
  /// One ray/triangle test.
  double leaf = CostModel{}.leaf;
};

/// Two nodes whose primitives may be better shared out anew.
struct NodePair {
  static constexpr std::uint32_t none = 0xFFFFFFFFu;
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t ancestor = 0;   ///< n_A, the lowest node above both
  std::uint32_t parent = none;  ///< the pair this one is a refinement of, by number
  double benefit = 0.0;         ///< Ben, of this pair alone
  double total = 0.0;           ///< with all its refinements
  double cost = 0.0;
};

/// Whether boxes share a volume; touching is not enough, but in an axis in which one of them is
/// flat it counts.
bool overlap(const Aabb& a, const Aabb& b);

/// The metric of Yoon, Curtis, Manocha 2007, section 4.2: what restructuring a pair would save and
/// cost. Probabilities are relative to the root, since benefits of all levels are compared with the
/// cost of one rebuild; the paper writes them relative to the parent. Its N_r, left out there for
/// simplicity, is in `weight`.
class RestructuringBenefit {
 public:
  /// `weight`: rays a frame that hit the root's box, times frames for which it lasts (Life).
  RestructuringBenefit(const LivingBvh& tree, const RestructureConfig& config, double weight);

  /// Eq. 4 with Eq. 2 and 3: assumes that the overlap vanishes and nothing grows.
  double benefit(const NodePair& pair) const;
  /// Eq. 5.
  double cost(const NodePair& pair) const;
  double rebuild_cost(std::uint32_t prims) const;
  /// What could at most be found below: for pairs whose own benefit is 0, so that damage under
  /// disjoint nodes is reached. Only damaged nodes count.
  double potential(const NodePair& pair) const;
  /// No operation saves more than all that both nodes cost, nor brings back more than was lost in
  /// them and on the way up to their ancestor since they were last in order (Eq. 7). The latter is
  /// ours: overlap that was there in a good pose does not vanish, though Eq. 2 takes it to.
  double cap(const NodePair& pair) const;

 private:
  double below(std::uint32_t node) const;

  const LivingBvh& tree_;
  const RestructureConfig& config_;
  double weight_;
  double root_area_;
};

/// For how many frames an operation is expected to last (Eq. 6): all nodes of all frames so far
/// over all nodes built, where the first build counts as one rebuild.
class LifeTime {
 public:
  void count_frame(std::uint64_t nodes) { nodes_ += double(nodes); }
  void count_built(std::uint64_t nodes) { built_ += double(nodes); }
  /// `frames_left` 0: not known.
  double frames(std::uint32_t frames_left) const;

 private:
  double nodes_ = 0.0;
  double built_ = 0.0;
};

}  // namespace regraft::bvh
