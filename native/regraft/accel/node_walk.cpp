#include <map>
#include <unordered_set>

#include "regraft/accel/accelerator_state.h"

namespace regraft::accel {

namespace {

using Nodes = std::unordered_set<std::uint32_t>;

/// Walks down from the root of the top tree; at leaves of two levels into the trees of meshes.
class NodeWalk {
 public:
  NodeWalk(const Tlas& tlas, const InstanceSet& instances, bool two_level, std::uint64_t update)
      : tlas_(tlas), instances_(instances), two_level_(two_level), update_(update) {}

  NodeBatch at_depth(std::uint32_t depth) {
    walk([&](const Place& place) { return place.depth == depth; },
         [](const KeptTree&, std::uint32_t) { return true; });
    return std::move(batch_);
  }

  /// The highest of those that were made anew.
  NodeBatch rebuilt() {
    const auto is_new = [&](const KeptTree& tree, std::uint32_t n) {
      return made(tree).contains(n);
    };
    walk([&](const Place& place) { return is_new(*place.tree, place.node); }, is_new);
    return std::move(batch_);
  }

 private:
  struct Place {
    const KeptTree* tree;
    std::uint32_t node;
    std::uint32_t depth;
    std::uint32_t instance;  ///< `invalid_id`: the top tree
  };

  /// Adds nodes at which `stop` is true, and leaves that come before if `wanted` says so.
  template <typename Stop, typename Wanted>
  void walk(const Stop& stop, const Wanted& wanted) {
    std::vector<Place> open;
    if (!tlas_.bvh().empty()) open.push_back({&tlas_.tree(), 0, 0, invalid_id});
    while (!open.empty()) {
      const Place place = open.back();
      open.pop_back();
      const bvh::Node& node = place.tree->bvh().nodes[place.node];
      if (stop(place)) {
        add(place);
      } else if (!node.leaf()) {
        for (std::uint32_t side = 2; side-- > 0;)
          open.push_back({place.tree, node.first + side, place.depth + 1, place.instance});
      } else if (two_level_ && place.instance == invalid_id) {
        for (std::uint32_t i = node.count; i-- > 0;) {
          const std::uint32_t instance = tlas_.bvh().prim_ids[node.first + i];
          open.push_back({&instances_.tree(instance).tree(), 0, place.depth, instance});
        }
      } else if (wanted(*place.tree, place.node)) {
        add(place);
      }
    }
  }

  void add(const Place& place) {
    Aabb box = place.tree->bvh().nodes[place.node].bounds();
    if (box.empty()) return;
    if (place.instance != invalid_id) {
      const float magnitude = instances_.views()[place.instance].mesh.magnitude;
      box = transform_bounds(instances_.frame(place.instance), box, magnitude);
    }
    std::array<double, 6>& corners = batch_.boxes.emplace_back();
    for (int k = 0; k < 3; ++k) {
      corners[std::size_t(k)] = double(box.lo[k]) + instances_.origin()[k];
      corners[std::size_t(k) + 3] = double(box.hi[k]) + instances_.origin()[k];
    }
    batch_.damage.push_back(place.tree->damage(place.node));
    const Nodes& nodes = made(*place.tree);
    batch_.rebuilt.push_back(nodes.contains(0) || above_[place.tree].contains(place.node) ||
                             nodes.contains(place.node));
  }

  /// What was made anew of a tree; `above_` then holds all that lies above it.
  const Nodes& made(const KeptTree& tree) {
    const auto [place, is_first] = made_.try_emplace(&tree);
    if (!is_first) return place->second;
    Nodes& above = above_[&tree];
    for (std::uint32_t n : tree.made_in(update_)) {
      place->second.insert(n);
      while (n != 0 && above.insert(n = tree.parent(n)).second) continue;
    }
    return place->second;
  }

  const Tlas& tlas_;
  const InstanceSet& instances_;
  bool two_level_;
  std::uint64_t update_;
  std::map<const KeptTree*, Nodes> made_;
  std::map<const KeptTree*, Nodes> above_;
  NodeBatch batch_;
};

}  // namespace

NodeBatch Accelerator::nodes_at(std::uint32_t depth) const {
  if (state_->kdtree.tree() != nullptr) return {};
  state_->finish_late();
  const bool two_level = state_->last_options.layout == Layout::two_level;
  return NodeWalk(state_->tlas, state_->instances, two_level, state_->updates).at_depth(depth);
}

NodeBatch Accelerator::rebuilt_nodes() const {
  if (state_->kdtree.tree() != nullptr) return {};
  const bool two_level = state_->last_options.layout == Layout::two_level;
  return NodeWalk(state_->tlas, state_->instances, two_level, state_->updates).rebuilt();
}

}  // namespace regraft::accel
