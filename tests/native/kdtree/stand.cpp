#include "kdtree/stand.h"

#include <stdexcept>

namespace regraft::test {

void Watched::open(const HierarchyEntry& entry, std::vector<HierarchyEntry>& out) const {
  {
    const std::lock_guard lock(mutex_);
    if (left_-- == 0) throw std::runtime_error("opened too much");
    opened_.insert({entry.kind, entry.object, entry.node});
  }
  view_.open(entry, out);
}

Watched::Opened Watched::opened() const {
  const std::lock_guard lock(mutex_);
  return opened_;
}

const HierarchyView& Stand::hierarchy() {
  accel::UpdateOptions options;
  options.structure = accel::Structure::kdtree;
  accelerator_.update(scene, scene.take_changes(), options, 4, pool(1));
  if (accelerator_.view().kdtree == nullptr) throw std::logic_error("nothing to hit");
  return accelerator_.view().kdtree->view();
}

trace::TraceView Stand::view(const kdtree::KdTree& tree) const {
  trace::TraceView view = accelerator_.view();
  view.kdtree = &tree;
  return view;
}

std::string Stand::differences(const kdtree::KdTree& tree, std::span<const Ray> rays) const {
  return difference(view(tree), 4, rays, hits_anew(scene, rays));
}

std::vector<kdtree::Config> all_configurations() {
  std::vector<kdtree::Config> all;
  for (const bool lazy : {false, true})
    for (const bool scan : {false, true})
      for (const bool hierarchy : {false, true}) {
        kdtree::Config config;
        config.lazy = lazy;
        config.scan = scan;
        config.hierarchy = hierarchy;
        all.push_back(config);
      }
  return all;
}

namespace {

void add_planes(const kdtree::Node& node, const std::string& path,
                std::map<std::string, std::pair<int, float>>& out) {
  const std::uint32_t state = node.state.load();
  if (!kdtree::Node::is_inner(state)) return;
  out[path] = {int(state), node.split};
  add_planes(node.children[0], path + "0", out);
  add_planes(node.children[1], path + "1", out);
}

}  // namespace

std::map<std::string, std::pair<int, float>> planes(const kdtree::KdTree& tree) {
  std::map<std::string, std::pair<int, float>> all;
  add_planes(tree.root(), "", all);
  return all;
}

std::vector<Ray> crossing_rays(std::uint64_t seed, std::size_t count, double reach) {
  Random random(seed);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d from = (i % 2 == 0 ? 3.0 : 0.5) * reach * random.way();
    rays.push_back({from, random.in_box(reach) - from});
  }
  return rays;
}

}  // namespace regraft::test
