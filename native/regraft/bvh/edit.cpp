#include "regraft/bvh/edit.h"

#include <algorithm>
#include <numeric>
#include <queue>

#include "regraft/core/growth.h"
#include "regraft/core/vec.h"

namespace regraft::bvh {

namespace {

Aabb united(const Aabb& a, const Aabb& b) {
  Aabb both = a;
  both.extend(b);
  return both;
}

class Edit {
 public:
  Edit(Bvh& bvh, const PrimitiveEdit& change, const std::function<Box4(std::uint32_t)>& bounds,
       Reshaping& changes)
      : bvh_(bvh), change_(change), bounds_(bounds), changes_(changes) {}

  /// Drops and renames primitives below `n` and measures it. @return whether anything is left.
  bool shrink(std::uint32_t n) {
    if (bvh_.nodes[n].leaf()) return shrink_leaf(n);
    const std::uint32_t first = bvh_.nodes[n].first;
    const bool left = shrink(first);
    const bool right = shrink(first + 1);
    if (left && right) {
      bvh_.nodes[n].set_bounds(united(bvh_.nodes[first].bounds(), bvh_.nodes[first + 1].bounds()));
      return true;
    }
    bvh_.free_pairs.push_back(first);
    if (left || right) {
      bvh_.nodes[n] = bvh_.nodes[left ? first : first + 1];
      changes_.replaced.push_back(n);
    }
    bvh_.nodes[first] = bvh_.nodes[first + 1] = {};
    return left || right;
  }

  /// Hangs `part` into the tree. @return false if that is impossible.
  bool insert(const Bvh& part) {
    if (bvh_.empty()) {
      bvh_ = part;
      changes_.rebuilt.push_back(0);
      return true;
    }
    if (bvh_.depth + part.depth + 2 > max_depth) measure_depth();
    const std::vector<std::uint32_t> path = find_place(part.nodes[0].bounds());
    const auto depth = std::uint32_t(path.size());
    if (bvh_.depth + 1 > max_depth || depth + part.depth > max_depth) return false;
    const std::uint32_t pair = allocate_pair();
    const std::uint32_t at = path.back();
    bvh_.nodes[pair] = bvh_.nodes[at];
    graft(part, pair + 1);
    bvh_.nodes[at].first = pair;
    bvh_.nodes[at].count = 0;
    for (const std::uint32_t n : path)
      bvh_.nodes[n].set_bounds(united(bvh_.nodes[n].bounds(), part.nodes[0].bounds()));
    bvh_.depth = std::max(bvh_.depth + 1, depth + part.depth);
    changes_.replaced.push_back(at);
    changes_.new_pairs.push_back(pair);
    changes_.rebuilt.push_back(pair + 1);
    return true;
  }

  void measure_depth() { bvh_.depth = bvh_.empty() ? 0 : height(0); }

 private:
  bool shrink_leaf(std::uint32_t n) {
    Node& node = bvh_.nodes[n];
    const std::uint32_t count = node.count;
    node.count = 0;
    Box4 box;
    for (std::uint32_t i = node.first; i < node.first + count; ++i) {
      const std::uint32_t old = bvh_.prim_ids[i];
      const std::uint32_t id = change_.new_ids.empty() ? old : change_.new_ids[old];
      if (id == invalid_id) continue;
      bvh_.prim_ids[node.first + node.count++] = id;
      box.extend(bounds_(id));
    }
    if (node.count != count) changes_.replaced.push_back(n);
    node.set_bounds(box.aabb());
    return node.count > 0;
  }

  /// A node below which a part may hang, and what it costs to get there.
  struct Open {
    double bound;   ///< no place below costs less
    double growth;  ///< Σ growth of the areas above it
    std::uint32_t step;
    bool operator<(const Open& other) const {
      return bound != other.bound ? bound > other.bound : step > other.step;
    }
  };
  struct Step {
    std::uint32_t node;
    std::uint32_t from;
  };

  /// The nodes from the root to the one whose sibling a box should become: areas grow least.
  std::vector<std::uint32_t> find_place(const Aabb& box) const {
    const double area = half_area(box);
    std::vector<Step> steps{{0, 0}};
    std::priority_queue<Open> open;
    open.push({area, 0.0, 0});
    std::uint32_t best = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    while (!open.empty() && open.top().bound < best_cost) {
      const Open item = open.top();
      open.pop();
      const Node& node = bvh_.nodes[steps[item.step].node];
      const double whole = half_area(united(node.bounds(), box));
      if (item.growth + whole < best_cost) {
        best_cost = item.growth + whole;
        best = item.step;
      }
      const double growth = item.growth + whole - half_area(node.bounds());
      if (node.leaf() || growth + area >= best_cost) continue;
      for (std::uint32_t side = 0; side < 2; ++side) {
        open.push({growth + area, growth, std::uint32_t(steps.size())});
        steps.push_back({node.first + side, item.step});
      }
    }
    std::vector<std::uint32_t> path;
    for (std::uint32_t s = best; s != 0; s = steps[s].from) path.push_back(steps[s].node);
    path.push_back(0);
    std::reverse(path.begin(), path.end());
    return path;
  }

  std::uint32_t allocate_pair() {
    if (!bvh_.free_pairs.empty()) {
      const std::uint32_t pair = bvh_.free_pairs.back();
      bvh_.free_pairs.pop_back();
      return pair;
    }
    const auto pair = std::uint32_t(bvh_.nodes.size());
    grow(bvh_.nodes, pair + 2);
    return pair;
  }

  /// Copies a part's nodes below and including `root`, and its primitives to the end.
  void graft(const Bvh& part, std::uint32_t root) {
    const auto offset = std::uint32_t(bvh_.prim_ids.size());
    bvh_.prim_ids.insert(bvh_.prim_ids.end(), part.prim_ids.begin(), part.prim_ids.end());
    std::vector<std::uint32_t> place(part.nodes.size() / 2);
    for (std::size_t p = 1; p < place.size(); ++p) place[p] = allocate_pair();
    for (std::uint32_t n = 0; n < part.nodes.size(); ++n) {
      if (n == 1) continue;
      Node node = part.nodes[n];
      node.first = node.leaf() ? node.first + offset : place[node.first / 2];
      bvh_.nodes[n == 0 ? root : place[n / 2] + n % 2] = node;
    }
  }

  std::uint32_t height(std::uint32_t n) const {
    const Node& node = bvh_.nodes[n];
    return node.leaf() ? 0 : 1 + std::max(height(node.first), height(node.first + 1));
  }

  Bvh& bvh_;
  const PrimitiveEdit& change_;
  const std::function<Box4(std::uint32_t)>& bounds_;
  Reshaping& changes_;
};

/// Lays the primitives out without holes, in the order in which leaves hold them now.
void pack(Bvh& bvh, std::size_t live) {
  std::vector<std::uint32_t> leaves, open{0}, packed;
  while (!open.empty()) {
    const std::uint32_t n = open.back();
    open.pop_back();
    const std::uint32_t first = bvh.nodes[n].first;
    if (bvh.nodes[n].leaf())
      leaves.push_back(n);
    else
      open.insert(open.end(), {first + 1, first});
  }
  packed.reserve(live);
  for (const std::uint32_t n : leaves) {
    Node& leaf = bvh.nodes[n];
    const auto begin = bvh.prim_ids.begin() + leaf.first;
    leaf.first = std::uint32_t(packed.size());
    packed.insert(packed.end(), begin, begin + leaf.count);
  }
  bvh.prim_ids.swap(packed);
}

Bvh build_chunk(const std::vector<std::uint32_t>& ids,
                const std::function<Box4(std::uint32_t)>& bounds,
                const BinnedSahBuilder::Config& builder, Executor& executor) {
  std::vector<Aabb> boxes;
  std::vector<std::uint32_t> numbers(ids.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  for (const std::uint32_t id : ids) boxes.push_back(bounds(id).aabb());
  Bvh part = BinnedSahBuilder::build(boxes, numbers, builder, executor);
  for (std::uint32_t& id : part.prim_ids) id = ids[id];
  return part;
}

std::size_t count_prims(const Bvh& bvh, std::uint32_t n) {
  const Node& node = bvh.nodes[n];
  return node.leaf() ? node.count : count_prims(bvh, node.first) + count_prims(bvh, node.first + 1);
}

}  // namespace

bool edit(Bvh& bvh, const PrimitiveEdit& change, const std::function<Box4(std::uint32_t)>& bounds,
          const BinnedSahBuilder::Config& builder, Executor& executor, Reshaping& changes) {
  Edit work(bvh, change, bounds, changes);
  if (!bvh.empty() && !work.shrink(0)) bvh = {};
  work.measure_depth();
  for (const std::vector<std::uint32_t>& chunk : change.added) {
    if (chunk.empty()) continue;
    if (!work.insert(build_chunk(chunk, bounds, builder, executor))) return false;
  }
  work.measure_depth();
  const std::size_t live = bvh.empty() ? 0 : count_prims(bvh, 0);
  if (2 * live < bvh.prim_ids.size()) {
    pack(bvh, live);
    changes = {{0}, {}, {}};
  }
  if (bvh.empty()) changes = {{0}, {}, {}};
  return true;
}

}  // namespace regraft::bvh
