#include "regraft/bvh/pair_refinement.h"

#include <algorithm>
#include <unordered_set>

namespace regraft::bvh {

namespace {

class Refinement {
 public:
  Refinement(const LivingBvh& tree, const RestructuringBenefit& metric,
             const RestructureConfig& config)
      : tree_(tree), nodes_(tree.bvh.nodes), metric_(metric), config_(config) {}

  std::vector<NodePair> run() {
    push_children(0, NodePair::none);
    for (std::uint32_t next = 0; next < pairs_.size(); ++next) visit(next);
    for (NodePair& pair : pairs_) {
      pair.total = std::min(pair.total, metric_.cap(pair));
      pair.cost = metric_.cost(pair);
    }
    return std::move(pairs_);
  }

 private:
  void visit(std::uint32_t number) {
    const NodePair pair = pairs_[number];
    const double benefit = metric_.benefit(pair);
    pairs_[number].benefit = benefit;
    for (std::uint32_t q = number; q != NodePair::none; q = pairs_[q].parent)
      pairs_[q].total += benefit;
    if (!tree_.damaged(pair.ancestor)) return;
    const double waiting = double(pairs_.size()) - number - 1.0;
    const double in_view = std::max(benefit, metric_.potential(pair));
    if (in_view > config_.refine * (waiting + 3.0)) refine(pair, number);
  }

  void refine(const NodePair& pair, std::uint32_t number) {
    if (!overlap(nodes_[pair.a].bounds(), nodes_[pair.b].bounds())) {
      push_children(pair.a, number);
      push_children(pair.b, number);
      return;
    }
    if (nodes_[pair.a].leaf() && nodes_[pair.b].leaf()) return;
    const bool a_is_larger = larger(pair.a, pair.b);
    const std::uint32_t opened = a_is_larger ? pair.a : pair.b;
    const std::uint32_t other = a_is_larger ? pair.b : pair.a;
    push(nodes_[opened].first, other, pair.ancestor, number);
    push(nodes_[opened].first + 1, other, pair.ancestor, number);
    push_children(opened, number);
    push_children(other, number);
  }

  /// Whether `a` rather than `b` is the one to open.
  bool larger(std::uint32_t a, std::uint32_t b) const {
    if (nodes_[a].leaf() || nodes_[b].leaf()) return nodes_[b].leaf();
    const auto volume = [&](std::uint32_t n) {
      const Vec3d e = nodes_[n].bounds().extents();
      return e.x * e.y * e.z;
    };
    if (volume(a) != volume(b)) return volume(a) > volume(b);
    if (tree_.area(a) != tree_.area(b)) return tree_.area(a) > tree_.area(b);
    return a < b;
  }

  void push_children(std::uint32_t node, std::uint32_t parent) {
    if (!nodes_[node].leaf()) push(nodes_[node].first, nodes_[node].first + 1, node, parent);
  }

  void push(std::uint32_t a, std::uint32_t b, std::uint32_t ancestor, std::uint32_t parent) {
    if (pairs_.size() >= config_.pair_limit) return;
    const auto [low, high] = std::minmax(a, b);
    if (known_.insert(std::uint64_t(low) << 32 | high).second)
      pairs_.push_back({a, b, ancestor, parent});
  }

  const LivingBvh& tree_;
  const AlignedVector<Node>& nodes_;
  const RestructuringBenefit& metric_;
  const RestructureConfig& config_;
  std::vector<NodePair> pairs_;
  std::unordered_set<std::uint64_t> known_;
};

}  // namespace

std::vector<NodePair> refine_pairs(const LivingBvh& tree, const RestructuringBenefit& metric,
                                   const RestructureConfig& config) {
  if (tree.bvh.empty()) return {};
  return Refinement(tree, metric, config).run();
}

}  // namespace regraft::bvh
