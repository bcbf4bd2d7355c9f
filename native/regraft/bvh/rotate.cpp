#include "regraft/bvh/rotate.h"

#include <algorithm>

#include "regraft/bvh/refit.h"

namespace regraft::bvh {

namespace {

/// Heights of a node and of its children; a leaf's are 0.
struct Heights {
  std::uint32_t own = 0;
  std::uint32_t child[2] = {0, 0};
};

/// The best exchange at a node: its child on `side` with the grandchild on `below` under the
/// other child, whose box becomes `box`.
struct Choice {
  std::uint32_t side = 0;
  std::uint32_t below = 0;
  double saving = 0.0;
  Aabb box;
};

class Pass {
 public:
  Pass(Bvh& bvh, const RotationScope& scope) : bvh_(bvh), scope_(scope) {}

  /// Stops at nodes of `frontier`, which is sorted and whose heights are in `known`.
  Heights visit_above(std::uint32_t n, std::uint32_t depth,
                      const std::vector<std::uint32_t>& frontier, const std::vector<Heights>& known,
                      std::vector<Rotation>& done) {
    const auto at = std::lower_bound(frontier.begin(), frontier.end(), n);
    if (at != frontier.end() && *at == n) return known[std::size_t(at - frontier.begin())];
    if (is_settled(n)) return heights_of_settled(n);
    const std::uint32_t first = bvh_.nodes[n].first;
    const Heights left = visit_above(first, depth + 1, frontier, known, done);
    const Heights right = visit_above(first + 1, depth + 1, frontier, known, done);
    return rotate_at(n, depth, left, right, done);
  }

  /// Depths of the nodes of the frontier; those below settled nodes keep theirs.
  void find_depths(std::uint32_t n, std::uint32_t depth, const std::vector<std::uint32_t>& frontier,
                   std::vector<std::uint32_t>& depths) const {
    const auto at = std::lower_bound(frontier.begin(), frontier.end(), n);
    if (at != frontier.end() && *at == n) {
      depths[std::size_t(at - frontier.begin())] = depth;
      return;
    }
    if (is_settled(n)) return;
    for (std::uint32_t side = 0; side < 2; ++side)
      find_depths(bvh_.nodes[n].first + side, depth + 1, frontier, depths);
  }

  Heights visit(std::uint32_t n, std::uint32_t depth, std::vector<Rotation>& done) {
    if (bvh_.nodes[n].leaf()) return {};
    if (is_settled(n)) return heights_of_settled(n);
    const std::uint32_t first = bvh_.nodes[n].first;
    const Heights left = visit(first, depth + 1, done);
    const Heights right = visit(first + 1, depth + 1, done);
    return rotate_at(n, depth, left, right, done);
  }

 private:
  bool is_settled(std::uint32_t n) const { return scope_.settled && scope_.settled(n); }
  Heights heights_of_settled(std::uint32_t n) const {
    const std::uint32_t first = bvh_.nodes[n].first;
    return {scope_.height(n), {scope_.height(first), scope_.height(first + 1)}};
  }

  Heights rotate_at(std::uint32_t n, std::uint32_t depth, const Heights& left, const Heights& right,
                    std::vector<Rotation>& done) {
    Heights pair[2] = {left, right};
    const Choice best = choose(n, depth, pair);
    if (best.saving > 1e-6 * half_area(bvh_.nodes[n].bounds())) {
      exchange(n, best, done);
      Heights& other = pair[1 - best.side];
      const std::uint32_t up = other.child[best.below];
      other.child[best.below] = pair[best.side].own;
      other.own = 1 + std::max(other.child[0], other.child[1]);
      pair[best.side].own = up;
    }
    return {1 + std::max(pair[0].own, pair[1].own), {pair[0].own, pair[1].own}};
  }

  Choice choose(std::uint32_t n, std::uint32_t depth, const Heights (&pair)[2]) const {
    Choice best;
    const std::uint32_t first = bvh_.nodes[n].first;
    for (std::uint32_t side = 0; side < 2; ++side) {
      const Node& down = bvh_.nodes[first + side];
      const Node& other = bvh_.nodes[first + 1 - side];
      if (other.leaf() || depth + 2 + pair[side].own > max_depth) continue;
      const double area = half_area(other.bounds());
      for (std::uint32_t below = 0; below < 2; ++below) {
        Box4 box(down.bounds());
        box.extend(Box4(bvh_.nodes[other.first + 1 - below].bounds()));
        const double saving = area - half_area(box.aabb());
        if (saving > best.saving) best = {side, below, saving, box.aabb()};
      }
    }
    return best;
  }

  void exchange(std::uint32_t n, const Choice& choice, std::vector<Rotation>& done) {
    const std::uint32_t child = bvh_.nodes[n].first + choice.side;
    Node& other = bvh_.nodes[child ^ 1u];
    const std::uint32_t grandchild = other.first + choice.below;
    std::swap(bvh_.nodes[child], bvh_.nodes[grandchild]);
    other.set_bounds(choice.box);
    done.push_back({n, child, grandchild});
  }

  Bvh& bvh_;
  const RotationScope& scope_;
};

}  // namespace

std::vector<Rotation> rotate(Bvh& bvh, const RotationScope& scope, Executor& executor) {
  if (bvh.empty()) return {};
  const std::vector<std::uint32_t> frontier = detail::refit_frontier(bvh);
  constexpr std::uint32_t not_asked = max_depth + 1;
  std::vector<std::uint32_t> depths(frontier.size(), not_asked);
  std::vector<Heights> heights(frontier.size());
  std::vector<std::vector<Rotation>> parts(frontier.size());
  Pass pass(bvh, scope);
  pass.find_depths(0, 0, frontier, depths);
  executor.parallel_for(frontier.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (depths[i] != not_asked) heights[i] = pass.visit(frontier[i], depths[i], parts[i]);
  });
  std::vector<Rotation> done;
  for (const auto& part : parts) done.insert(done.end(), part.begin(), part.end());
  bvh.depth = pass.visit_above(0, 0, frontier, heights, done).own;
  return done;
}

}  // namespace regraft::bvh
