#include "regraft/kdtree/validate.h"

#include <algorithm>
#include <set>
#include <vector>

namespace regraft::kdtree {

namespace {

bool precedes(const PrimRef& a, const PrimRef& b) {
  return a.object != b.object ? a.object < b.object : a.prim < b.prim;
}

/// All primitives below the entries that are anywhere.
std::vector<HierarchyEntry> primitives_below(const HierarchyView& view,
                                             std::vector<HierarchyEntry> stack) {
  std::vector<HierarchyEntry> found;
  while (!stack.empty()) {
    const HierarchyEntry entry = stack.back();
    stack.pop_back();
    if (!entry.primitive())
      view.open(entry, stack);
    else if (!entry.box.empty())
      found.push_back(entry);
  }
  return found;
}

std::vector<PrimRef> sorted_refs(const std::vector<HierarchyEntry>& entries) {
  std::vector<PrimRef> refs;
  for (const HierarchyEntry& e : entries) refs.push_back({e.object, e.node});
  std::sort(refs.begin(), refs.end(), precedes);
  return refs;
}

/// More than a touch, or a rounding, of each side that is not flat.
bool well_inside(const Aabb& part, const Aabb& voxel) {
  for (int k = 0; k < 3; ++k) {
    const double slack = 1e-6 * (double(voxel.hi[k]) - voxel.lo[k]);
    const double size = double(part.hi[k]) - part.lo[k];
    const bool flat = size <= slack;
    if (flat && (part.lo[k] <= voxel.lo[k] + slack || part.hi[k] >= voxel.hi[k] - slack))
      return false;
  }
  return !part.empty();
}

class Validator {
 public:
  explicit Validator(const KdTree& tree) : tree_(tree) {
    std::vector<HierarchyEntry> top;
    tree.view().top(top);
    all_ = primitives_below(tree.view(), top);
  }

  std::string run() {
    visit(tree_.root(), tree_.bounds(), 0, meeting(all_, tree_.bounds()));
    for (const HierarchyEntry& e : all_)
      if (error_.empty() && named_.count({e.object, e.node}) == 0 &&
          !tree_.view().clip(e, tree_.bounds()).empty())
        fail("primitive " + std::to_string(e.node) + " is in no cell");
    return error_;
  }

 private:
  void fail(const std::string& what) {
    if (error_.empty()) error_ = what;
  }

  using Entries = std::vector<HierarchyEntry>;

  Entries meeting(const Entries& some, const Aabb& voxel) const {
    Entries met;
    for (const HierarchyEntry& e : some)
      if (!tree_.view().clip(e, voxel).empty()) met.push_back(e);
    return met;
  }

  /// `met`: the primitives that meet the cell.
  void visit(const Node& node, const Aabb& voxel, std::uint32_t depth, const Entries& met) {
    if (!error_.empty()) return;
    const std::uint32_t state = node.state.load();
    if (depth > tree_.builder().max_depth()) return fail("a cell is too deep");
    if (Node::is_inner(state)) return visit_inner(node, int(state), voxel, depth, met);
    if (state == Node::building) return fail("a cell is still being built");
    std::vector<PrimRef> refs;
    if (Node::is_built(state)) {
      refs.assign(node.prims, node.prims + Node::prim_count(state));
      if (!std::is_sorted(refs.begin(), refs.end(), precedes)) fail("a leaf is not in order");
    } else {
      if (node.pending->voxel != voxel) fail("an unbuilt cell has another box than its place");
      refs = sorted_refs(primitives_below(tree_.view(), node.pending->list));
    }
    if (std::adjacent_find(refs.begin(), refs.end()) != refs.end())
      fail("a cell names a primitive twice");
    check_cell(refs, voxel, met);
  }

  void visit_inner(const Node& node, int axis, const Aabb& voxel, std::uint32_t depth,
                   const Entries& met) {
    if (!(voxel.lo[axis] < node.split && node.split < voxel.hi[axis]))
      return fail("a plane is not inside its cell");
    Aabb side[2] = {voxel, voxel};
    side[0].hi[axis] = side[1].lo[axis] = node.split;
    for (int s = 0; s < 2; ++s) visit(node.children[s], side[s], depth + 1, meeting(met, side[s]));
  }

  void check_cell(const std::vector<PrimRef>& refs, const Aabb& voxel, const Entries& met) {
    for (const PrimRef& ref : refs) named_.insert({ref.object, ref.prim});
    for (const HierarchyEntry& e : met) {
      const PrimRef ref{e.object, e.node};
      if (std::binary_search(refs.begin(), refs.end(), ref, precedes)) continue;
      if (well_inside(tree_.view().clip(e, voxel), voxel))
        return fail("primitive " + std::to_string(e.node) + " of object " +
                    std::to_string(e.object) + " is missing in a cell it meets");
    }
  }

  const KdTree& tree_;
  std::vector<HierarchyEntry> all_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> named_;
  std::string error_;
};

}  // namespace

std::string validate(const KdTree& tree) {
  return Validator(tree).run();
}

}  // namespace regraft::kdtree
