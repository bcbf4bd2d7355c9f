#include "regraft/accel/origin_cost.h"

#include "regraft/kdtree/origin_metric.h"

namespace regraft::accel {

namespace {

using kdtree::OriginMetric;

/// Calls `visit(node)` for all nodes of a tree.
template <typename Visit>
void for_each_node(const bvh::Bvh& tree, const Visit& visit) {
  std::vector<std::uint32_t> open;
  if (!tree.empty()) open.push_back(0);
  while (!open.empty()) {
    const bvh::Node& node = tree.nodes[open.back()];
    open.pop_back();
    if (!node.leaf()) open.insert(open.end(), {node.first, node.first + 1});
    visit(node);
  }
}

/// What a ray that visits the node does there.
double work(const bvh::Node& node) {
  return node.leaf() ? bvh::CostModel{}.leaf * double(node.count) : 1.0;
}

}  // namespace

double origin_cost(const Tlas& tlas, const InstanceSet& instances, bool two_level) {
  const Aabb origins = tlas.bounds();
  const auto chance = [&](const Aabb& box) {
    return kdtree::visit_probability(OriginMetric::regions6, origins, box);
  };
  double sum = 0.0;
  for_each_node(tlas.bvh(), [&](const bvh::Node& node) {
    if (!two_level || !node.leaf()) {
      sum += chance(node.bounds()) * work(node);
      return;
    }
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const std::uint32_t instance = tlas.bvh().prim_ids[node.first + i];
      const float magnitude = instances.views()[instance].mesh.magnitude;
      for_each_node(instances.tree(instance).bvh(), [&](const bvh::Node& below) {
        const Aabb box = transform_bounds(instances.frame(instance), below.bounds(), magnitude);
        sum += chance(box) * work(below);
      });
    }
  });
  return sum;
}

}  // namespace regraft::accel
