#pragma once

#include <functional>
#include <vector>

#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/living_bvh.h"
#include "regraft/bvh/restructuring_benefit.h"

namespace regraft::bvh {

/// The present box of a primitive; the empty box for one that cannot be hit.
using PrimBoxes = std::function<Box4(std::uint32_t)>;

/// What takes the place of a node: a tree whose ends are new leaves and subtrees that stay.
struct Scion {
  /// Marks an inner node that stays: the rest of `first` is its pair in the tree.
  static constexpr std::uint32_t stays = 0x80000000u;
  std::vector<Node> nodes;  ///< as in a Bvh; leaves name places in `Bvh::prim_ids`
};

/// New subtrees for a pair of nodes that lie not below each other, over the primitives of both. The
/// nodes keep their places in the tree.
struct Graft {
  std::uint32_t node[2] = {0, 0};
  Scion scion[2];
  /// What new leaves hold: places in `Bvh::prim_ids`, ascending by leaf, and primitives.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> prims;
  /// Pairs of nodes that become free, ascending.
  std::vector<std::uint32_t> pairs;
  /// False: the nodes lie too deep for new subtrees.
  bool possible = true;
  /// Σ area·tests that the new subtrees save, all taken for seen; known before anything is touched,
  /// so that what would make the tree worse is not done.
  double saving = 0.0;
};

/// Where and with what to graft.
struct GraftSite {
  const LivingBvh& tree;
  const NodePair& pair;
  const PrimBoxes& boxes;
  const BinnedSahBuilder::Config& builder;
  /// The pair is taken apart into so many parts, the largest and most damaged first; 0: into those
  /// that are in order.
  std::size_t parts = 0;
};

/// Shares what is below a pair out anew and builds both sides (Yoon, Curtis, Manocha 2007, section
/// 5). Reads the tree only: any number of disjoint pairs may be prepared at once.
///
/// Deviation: not down to the primitives. Subtrees without damage stay whole, as in rebuilding from
/// a hierarchy's cut (Hunt, Mark, Fussell 2007), so the work is that of the damage alone.
Graft prepare_graft(const GraftSite& site, Executor& executor);

/// Puts new subtrees into their places and measures what is above them; references from the nodes
/// up to `ancestor` become those of now.
/// @return the nodes that now hold something else.
std::vector<std::uint32_t> apply_graft(LivingBvh& tree, const Graft& graft, std::uint32_t ancestor);

/// Takes the present state of a pair and the way up to its ancestor for good: it was tried.
void accept_damage(LivingBvh& tree, const NodePair& pair);

}  // namespace regraft::bvh
