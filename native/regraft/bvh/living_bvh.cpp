#include "regraft/bvh/living_bvh.h"

#include <algorithm>

#include "regraft/core/growth.h"

namespace regraft::bvh {

namespace {

/// Growth below this share is the rounding of areas.
constexpr double rounding = 1e-9;

}  // namespace

double LivingBvh::leaf_cost(const Node& leaf) const {
  if (prim_costs.empty()) return leaf.count * model.leaf;
  double sum = 0.0;
  for (std::uint32_t i = 0; i < leaf.count; ++i) sum += prim_costs[bvh.prim_ids[leaf.first + i]];
  return sum;
}

double LivingBvh::cost(std::uint32_t n) const {
  const Node& node = bvh.nodes[n];
  return node.leaf() ? leaf_cost(node) : inner[node.first >> 1].cost;
}

double LivingBvh::excess(std::uint32_t n) const {
  const Node& node = bvh.nodes[n];
  return node.leaf() ? 0.0 : inner[node.first >> 1].excess;
}

std::uint32_t LivingBvh::prims(std::uint32_t n) const {
  const Node& node = bvh.nodes[n];
  return node.leaf() ? node.count : inner[node.first >> 1].prims;
}

std::uint32_t LivingBvh::height(std::uint32_t n) const {
  const Node& node = bvh.nodes[n];
  return node.leaf() ? 0 : inner[node.first >> 1].height;
}

std::uint32_t LivingBvh::units(std::uint32_t n) const {
  const Node& node = bvh.nodes[n];
  return node.leaf() ? node.count : inner[node.first >> 1].units;
}

std::uint32_t LivingBvh::depth(std::uint32_t n) const {
  std::uint32_t depth = 0;
  for (; n != 0; n = parent(n)) ++depth;
  return depth;
}

void LivingBvh::measure(std::uint32_t n) {
  const Node& node = bvh.nodes[n];
  InnerMetrics& m = inner[node.first >> 1];
  const bool leaves_seen = seen[node.first >> 1] != 0;
  const double whole = area(n);
  m.node = n;
  m.cost = 1.0;
  m.excess = 0.0;
  m.prims = 0;
  m.height = 1;
  m.units = 0;
  double own = 0.0;
  for (std::uint32_t side = 0; side < 2; ++side) {
    const Node& child = bvh.nodes[node.first + side];
    const double part = half_area(child.bounds());
    double tests = 0.0;
    bool is_seen = leaves_seen;
    if (child.leaf()) {
      tests = leaf_cost(child);
      m.prims += child.count;
      m.units += child.count;
    } else {
      const InnerMetrics& below = inner[child.first >> 1];
      tests = below.cost;
      m.excess += below.excess;
      m.prims += below.prims;
      m.units += below.units;
      m.height = std::max(m.height, below.height + 1);
      is_seen = seen[child.first >> 1] != 0;
    }
    const double grown = part * (1.0 - rounding) - m.reference[side] * whole;
    own += grown * tests;
    if (is_seen)
      m.cost += tests * (whole > 0.0 ? std::fmin(1.0, part / whole)
                                     : hit_probability(child.bounds(), node.bounds()));
  }
  m.excess += std::max(own, 0.0);
  if (!(m.excess > unit_damage * m.cost * whole)) m.units = 1;
}

void LivingBvh::set_reference(std::uint32_t n) {
  const Node& node = bvh.nodes[n];
  const double whole = area(n);
  // Proportions of a box without area say nothing: whatever it grows into is to be looked at.
  for (std::uint32_t side = 0; side < 2; ++side)
    inner[node.first >> 1].reference[side] = whole > 0.0 ? area(node.first + side) / whole : 0.0;
  inner[node.first >> 1].volume_ratio = float(volume_ratio(n));
}

double LivingBvh::volume_ratio(std::uint32_t n) const {
  const auto volume = [&](std::uint32_t i) {
    const Vec3d e = bvh.nodes[i].bounds().extents();
    return e.x * e.y * e.z;
  };
  const std::uint32_t first = bvh.nodes[n].first;
  const double below = volume(first) + volume(first + 1);
  return below > 0.0 ? volume(n) / below : 0.0;
}

void LivingBvh::measure_anew(std::uint32_t n, std::span<const std::uint32_t> done) {
  const Node& node = bvh.nodes[n];
  if (node.leaf() || std::binary_search(done.begin(), done.end(), n)) return;
  measure_anew(node.first, done);
  measure_anew(node.first + 1, done);
  set_reference(n);
  measure(n);
}

void LivingBvh::start_measuring(Executor& executor) {
  inner.clear();
  seen.clear();
  grow(inner, bvh.nodes.size() / 2);
  grow(seen, inner.size(), std::uint8_t(1));
  if (bvh.empty()) return;
  const std::vector<std::uint32_t> frontier = detail::refit_frontier(bvh);
  executor.parallel_for(frontier.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) measure_anew(frontier[i]);
  });
  if (frontier[0] != 0) measure_anew(0, frontier);
}

void LivingBvh::stop_measuring() {
  inner = {};
  seen = {};
}

}  // namespace regraft::bvh
