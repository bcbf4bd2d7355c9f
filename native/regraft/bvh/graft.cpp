#include "regraft/bvh/graft.h"

#include <algorithm>
#include <bit>

#include "regraft/bvh/cut.h"
#include "regraft/bvh/share_out.h"
#include "regraft/bvh/slot_pool.h"
#include "regraft/core/growth.h"

namespace regraft::bvh {

namespace {

/// Leaves for whose primitives there are no places side by side are split: levels kept for that.
constexpr std::uint32_t spare_levels = 4;
/// Subtrees in order are opened too while their area exceeds this share of the pair's: what was
/// far from all else may have moved into it.
constexpr double large_share = 1.0 / 64.0;

/// Where the children of the ancestor overlap: the middle along its longest axis.
Plane partition_plane(const Bvh& bvh, std::uint32_t ancestor) {
  const Vec3d e = bvh.nodes[ancestor].bounds().extents();
  const int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
  const Node& left = bvh.nodes[bvh.nodes[ancestor].first];
  const Node& right = bvh.nodes[bvh.nodes[ancestor].first + 1];
  const double lo = std::max(left.lo[axis], right.lo[axis]);
  const double hi = std::min(left.hi[axis], right.hi[axis]);
  return {axis, 0.5 * (lo + hi)};
}

class Preparation {
 public:
  Preparation(const GraftSite& site, Executor& executor)
      : tree_(site.tree),
        pair_(site.pair),
        source_(site.boxes),
        config_(site.builder),
        parts_(site.parts),
        executor_(executor) {}

  Graft run() {
    graft_.node[0] = pair_.a;
    graft_.node[1] = pair_.b;
    const std::size_t first = open();
    const Sides sides = choose_sides(first);
    SlotPool pool(slots());
    graft_.saving = cut_.tests;
    for (int side = 0; side < 2 && graft_.possible; ++side)
      build(side, sides[std::size_t(side)], pool);
    graft_.pairs = std::move(cut_.pairs);
    std::sort(graft_.pairs.begin(), graft_.pairs.end());
    return std::move(graft_);
  }

 private:
  std::size_t cut() {
    if (parts_ > 0) return cut_.open_worst(tree_, pair_.a, pair_.b, parts_);
    Aabb both = tree_.bvh.nodes[pair_.a].bounds();
    both.extend(tree_.bvh.nodes[pair_.b].bounds());
    const double large = half_area(both) * large_share;
    cut_.open(tree_, pair_.a, large);
    const std::size_t first = cut_.units.size();
    cut_.open(tree_, pair_.b, large);
    return first;
  }

  /// Takes both subtrees apart; returns how many units are of the first.
  std::size_t open() {
    const std::size_t first = cut();
    boxes_.resize(cut_.units.size());
    // What cannot be hit lies, for the time of building, where something else lies.
    Aabb stand_in{Vec3(0.0f), Vec3(0.0f)};
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      Node& unit = cut_.units[i];
      if (unit.leaf()) unit.set_bounds(source_(tree_.bvh.prim_ids[unit.first]).aabb());
      boxes_[i] = unit.bounds();
      if (!boxes_[i].empty()) stand_in = boxes_[i];
    }
    for (Aabb& box : boxes_)
      if (box.empty()) box = stand_in;
    return first;
  }

  std::vector<std::uint32_t> slots() const {
    std::vector<std::uint32_t> result;
    for (const Node& unit : cut_.units)
      if (unit.leaf()) result.push_back(unit.first);
    return result;
  }

  /// Pairs that do not overlap won by what is below them: each side is put in order where it is.
  Sides choose_sides(std::size_t first) const {
    const Bvh& bvh = tree_.bvh;
    if (!overlap(bvh.nodes[pair_.a].bounds(), bvh.nodes[pair_.b].bounds()))
      return as_they_are(boxes_.size(), first);
    Sides sides = share_out(boxes_, first, partition_plane(bvh, pair_.ancestor));
    const Aabb lower = bounds(sides[0]);
    const Aabb upper = bounds(sides[1]);
    if (stretch(pair_.b, lower) + stretch(pair_.a, upper) <
        stretch(pair_.a, lower) + stretch(pair_.b, upper))
      std::swap(sides[0], sides[1]);
    return sides;
  }

  Aabb bounds(const std::vector<std::uint32_t>& side) const {
    Aabb sum;
    for (const std::uint32_t i : side) sum.extend(boxes_[i]);
    return sum;
  }

  /// By how much the nodes from `node` up to the ancestor grow if `node` gets the box `box`.
  double stretch(std::uint32_t node, Aabb box) const {
    double sum = 0.0;
    while (tree_.parent(node) != pair_.ancestor) {
      box.extend(tree_.bvh.nodes[node ^ 1u].bounds());
      node = tree_.parent(node);
      sum += half_area(box) - tree_.area(node);
    }
    return sum;
  }

  void build(int side, const std::vector<std::uint32_t>& ids, SlotPool& pool) {
    std::uint32_t below = spare_levels;
    for (const std::uint32_t i : ids)
      if (!cut_.units[i].leaf())
        below = std::max(below, tree_.inner[cut_.units[i].first >> 1].height);
    const std::uint32_t depth = tree_.depth(graft_.node[side]) + below;
    if (depth + std::uint32_t(std::bit_width(ids.size())) + 2 > config_.max_depth) {
      graft_.possible = false;
      return;
    }
    BinnedSahBuilder::Config config = config_;
    config.max_leaf = 1;
    config.max_depth -= depth;
    const Bvh part = BinnedSahBuilder::build(boxes_, ids, config, executor_);
    std::vector<Node>& nodes = graft_.scion[side].nodes;
    nodes.resize(2);
    adopt(part, 0, nodes, 0, pool);
    graft_.saving -= stretch(graft_.node[side], nodes[0].bounds());
  }

  /// Number of primitives below, if there are only primitives and no more than fit a leaf; else 0.
  std::uint32_t only_prims(const Bvh& part, std::uint32_t n) const {
    const Node& node = part.nodes[n];
    if (node.leaf()) return cut_.units[part.prim_ids[node.first]].leaf() ? 1 : 0;
    const std::uint32_t left = only_prims(part, node.first);
    const std::uint32_t right = left == 0 ? 0 : only_prims(part, node.first + 1);
    return right == 0 || left + right > config_.max_leaf ? 0 : left + right;
  }

  /// Copies a subtree of `part`, in which every unit has a leaf of its own, joins primitives to
  /// leaves where that is cheaper, and finds them places.
  void adopt(const Bvh& part, std::uint32_t from, std::vector<Node>& nodes, std::uint32_t to,
             SlotPool& pool) {
    const Node& node = part.nodes[from];
    const Node* unit = node.leaf() ? &cut_.units[part.prim_ids[node.first]] : nullptr;
    if (unit != nullptr && !unit->leaf()) {
      nodes[to] = *unit;
      nodes[to].first |= Scion::stays;
      return;
    }
    const std::uint32_t prims = only_prims(part, from);
    if (prims > 0 && (prims == 1 || is_cheaper_as_leaf(part, node, prims))) {
      std::vector<std::uint32_t> units;
      list_units(part, from, units);
      place(units, nodes, to, pool);
      return;
    }
    const auto first = std::uint32_t(nodes.size());
    nodes.resize(nodes.size() + 2);
    adopt(part, node.first, nodes, first, pool);
    adopt(part, node.first + 1, nodes, first + 1, pool);
    close(nodes, to, first);
  }

  bool is_cheaper_as_leaf(const Bvh& part, const Node& node, std::uint32_t prims) const {
    double below = 0.0;
    for (std::uint32_t c = node.first; c < node.first + 2; ++c)
      below += half_area(part.nodes[c].bounds()) * only_prims(part, c);
    const double area = half_area(node.bounds());
    return !(area + config_.cost.leaf * below < config_.cost.leaf * prims * area);
  }

  static void list_units(const Bvh& part, std::uint32_t n, std::vector<std::uint32_t>& units) {
    const Node& node = part.nodes[n];
    if (node.leaf()) {
      units.push_back(part.prim_ids[node.first]);
      return;
    }
    list_units(part, node.first, units);
    list_units(part, node.first + 1, units);
  }

  /// An inner node over the pair at `first`.
  void close(std::vector<Node>& nodes, std::uint32_t n, std::uint32_t first) {
    Aabb box = nodes[first].bounds();
    box.extend(nodes[first + 1].bounds());
    nodes[n].set_bounds(box);
    nodes[n].first = first;
    nodes[n].count = 0;
    graft_.saving -= half_area(box);
  }

  /// A leaf, or two if there are no places for all side by side.
  void place(std::span<const std::uint32_t> units, std::vector<Node>& nodes, std::uint32_t to,
             SlotPool& pool) {
    auto count = std::uint32_t(units.size());
    const std::uint32_t slot = pool.take(count);
    std::uint32_t leaf = to;
    const auto first = std::uint32_t(nodes.size());
    if (count < units.size()) {
      nodes.resize(nodes.size() + 2);
      leaf = first;
      place(units.subspan(count), nodes, first + 1, pool);
    }
    Aabb box;
    double tests = 0.0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Node& unit = cut_.units[units[i]];
      const std::uint32_t prim = tree_.bvh.prim_ids[unit.first];
      graft_.prims.emplace_back(slot + i, prim);
      box.extend(unit.bounds());
      tests += tree_.prim_cost(prim);
    }
    nodes[leaf].set_bounds(box);
    nodes[leaf].first = slot;
    nodes[leaf].count = count;
    graft_.saving -= half_area(box) * tests;
    if (leaf != to) close(nodes, to, first);
  }

  const LivingBvh& tree_;
  const NodePair& pair_;
  const PrimBoxes& source_;
  const BinnedSahBuilder::Config& config_;
  std::size_t parts_;
  Executor& executor_;
  Graft graft_;
  Cut cut_;
  std::vector<Aabb> boxes_;
};

/// Copies new subtrees into a tree, reusing what their forerunners leave.
class Splice {
 public:
  Splice(LivingBvh& tree, const Graft& graft) : tree_(tree), bvh_(tree.bvh), graft_(graft) {}

  std::vector<std::uint32_t> run() {
    std::uint8_t seen[2];
    for (int side = 0; side < 2; ++side) seen[side] = seen_before(graft_.node[side]);
    for (const std::uint32_t first : graft_.pairs) bvh_.nodes[first] = bvh_.nodes[first + 1] = {};
    for (const auto& [slot, prim] : graft_.prims) bvh_.prim_ids[slot] = prim;
    for (int side = 0; side < 2; ++side) {
      const std::uint32_t n = graft_.node[side];
      // New nodes inherit whether they were seen.
      seen_ = seen[side];
      copy(graft_.scion[side].nodes, 0, n);
    }
    bvh_.free_pairs.insert(bvh_.free_pairs.end(),
                           graft_.pairs.begin() + std::ptrdiff_t(used_pairs_), graft_.pairs.end());
    return std::move(made_);
  }

 private:
  void copy(const std::vector<Node>& scion, std::uint32_t from, std::uint32_t to) {
    const Node& node = scion[from];
    bvh_.nodes[to] = node;
    made_.push_back(to);
    if (!node.leaf() && (node.first & Scion::stays) != 0) {
      const std::uint32_t first = node.first & ~Scion::stays;
      bvh_.nodes[to].first = first;
      tree_.inner[first >> 1].node = to;
      return;
    }
    if (node.leaf()) return;
    const std::uint32_t first = take_pair();
    bvh_.nodes[to].first = first;
    tree_.seen[first >> 1] = seen_;
    copy(scion, node.first, first);
    copy(scion, node.first + 1, first + 1);
    tree_.set_reference(to);
    tree_.measure(to);
  }

  std::uint8_t seen_before(std::uint32_t n) const {
    return tree_.seen[(bvh_.nodes[n].leaf() ? n : bvh_.nodes[n].first) >> 1];
  }

  std::uint32_t take_pair() {
    if (used_pairs_ < graft_.pairs.size()) return graft_.pairs[used_pairs_++];
    if (!bvh_.free_pairs.empty()) {
      const std::uint32_t first = bvh_.free_pairs.back();
      bvh_.free_pairs.pop_back();
      return first;
    }
    grow(bvh_.nodes, bvh_.nodes.size() + 2);
    grow(tree_.inner, bvh_.nodes.size() / 2);
    grow(tree_.seen, tree_.inner.size());
    return std::uint32_t(bvh_.nodes.size() - 2);
  }

  LivingBvh& tree_;
  Bvh& bvh_;
  const Graft& graft_;
  std::uint8_t seen_ = 1;
  std::size_t used_pairs_ = 0;
  std::vector<std::uint32_t> made_;
};

/// Boxes and metrics of everything above `node`.
void update_above(LivingBvh& tree, std::uint32_t node) {
  while (node != 0) {
    node = tree.parent(node);
    const std::uint32_t first = tree.bvh.nodes[node].first;
    Aabb box = tree.bvh.nodes[first].bounds();
    box.extend(tree.bvh.nodes[first + 1].bounds());
    tree.bvh.nodes[node].set_bounds(box);
    tree.measure(node);
  }
}

/// What is left of damage on the way up to `ancestor` was looked at and stays.
void set_references(LivingBvh& tree, std::uint32_t node, std::uint32_t ancestor) {
  while (node != ancestor) {
    node = tree.parent(node);
    tree.set_reference(node);
  }
}

}  // namespace

Graft prepare_graft(const GraftSite& site, Executor& executor) {
  return Preparation(site, executor).run();
}

void accept_damage(LivingBvh& tree, const NodePair& pair) {
  for (const std::uint32_t n : {pair.a, pair.b}) set_references(tree, n, pair.ancestor);
  for (const std::uint32_t n : {pair.a, pair.b}) update_above(tree, n);
}

std::vector<std::uint32_t> apply_graft(LivingBvh& tree, const Graft& graft,
                                       std::uint32_t ancestor) {
  const std::vector<std::uint32_t> made = Splice(tree, graft).run();
  for (const std::uint32_t n : graft.node) update_above(tree, n);
  for (const std::uint32_t n : graft.node) set_references(tree, n, ancestor);
  for (const std::uint32_t n : graft.node) update_above(tree, n);
  tree.bvh.depth = tree.height(0);
  return made;
}

}  // namespace regraft::bvh
