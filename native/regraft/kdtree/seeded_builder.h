#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "regraft/core/hierarchy_view.h"
#include "regraft/kdtree/node.h"
#include "regraft/kdtree/origin_choice.h"
#include "regraft/kdtree/sah_scan.h"

namespace regraft::kdtree {

/// Which entry of a node's list is opened next.
enum class Refine : std::uint8_t {
  fifo,  ///< the paper's rule
  area   ///< its footnote: the largest weight times area
};

/// Lazy × scan × hierarchy: the eight configurations of Hunt, Mark, Fussell 2007, Table 1.
struct Config {
  bool lazy = true;       ///< nodes are built when a ray enters them; otherwise all at once
  bool scan = true;       ///< splits by the error-bounded scan; otherwise by the exact sweep
  bool hierarchy = true;  ///< lists are seeded by the hierarchy; otherwise by all its primitives

  /// Entries up to which a node's list is refined: the paper's a. 10 is fast, 500 builds trees as
  /// good as those of the exact builder.
  std::uint32_t refine_to = 50;
  Refine refine = Refine::fifo;
  /// Entries across the best plane that are opened before it is chosen: the paper's d.
  std::uint32_t open_straddlers = 16;
  /// Kernels test four triangles of a leaf at once: one costs less than going down a node.
  SplitCost cost{1.0, 0.4, 0.3};
  ScanConfig precision;
  /// By which chances to split, and the box of ray origins they suppose.
  OriginChoice origins;
  /// References in all leaves for each primitive of the scene; beyond that nodes are not split.
  double references_per_primitive = 16.0;
};

/// "lazy+scan+hierarchy", "eager", "scan" and so on: which of the three are on.
std::string_view name(const Config& config);

/// What an unbuilt node is to be built from.
struct Pending {
  Aabb voxel;
  /// Boxes are cut to the voxel. No entry contains another, together they hold all of the scene
  /// that meets the voxel.
  std::vector<HierarchyEntry> list;
  /// References that the leaves below may use up; `by_weight`: as many as the list allows.
  double budget = 0.0;
  double weight = 0.0;  ///< of the list
  std::uint32_t depth = 0;

  static constexpr double by_weight = -1.0;
};

/// What became of a node: children, or a leaf's primitives.
struct Built {
  int axis = -1;
  float position = 0.0f;
  Pending children[2];
  std::vector<PrimRef> prims;
};

/// Builds one node of a k-d tree from the entries of a scene's hierarchy that meet it (Hunt, Mark,
/// Fussell, Fast and Lazy Build of Acceleration Structures from Scene Hierarchies, RT 2007).
///
/// Deviations: candidates are both ends of every entry, not only the lower ones, since upper ends
/// cut off empty space; a leaf is made only when no entry is left to open or the digging budget 5(a
/// + F) is spent, since coarse entries make every split look bad; all three axes are always looked
/// at, because the paper's own scene became slower without; triangles are clipped to the voxel as
/// soon as they are in a list, not only in leaves, and from then on by the plane that cuts them.
class SeededBuilder {
 public:
  SeededBuilder(const HierarchyView& view, const Config& config);

  /// The node everything else comes from. Its voxel is `bounds()`.
  Pending root() const;
  /// A node for a part of the scene's space, seeded from the top.
  Pending seed(const Aabb& voxel, std::uint32_t depth, double budget) const;
  const Config& config() const { return config_; }
  const Aabb& bounds() const { return bounds_; }
  double weight() const { return weight_; }
  std::uint32_t max_depth() const { return max_depth_; }

  /// Whether the node is a leaf whatever the entries are like: not even an empty half would pay.
  bool surely_leaf(const Pending& node) const;
  /// What the node becomes: a function of the node and the scene alone. O(a log a) but for leaves.
  Built build(const Pending& node) const;

 private:
  /// References to a list of this weight.
  double allowed(double weight) const { return config_.references_per_primitive * weight + 64.0; }
  Built make_inner(std::span<const HierarchyEntry> list, const Pending& node,
                   const Split& split) const;
  bool may_split(const Pending& node, double weight) const {
    return node.depth < max_depth_ && weight * config_.cost.intersect > config_.cost.traverse &&
           (node.budget == Pending::by_weight || weight <= node.budget);
  }

  const HierarchyView& view_;
  Config config_;
  Aabb bounds_;
  double weight_ = 0.0;
  std::uint32_t max_depth_ = 0;
};

}  // namespace regraft::kdtree
