#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "regraft/accel/blas.h"
#include "regraft/accel/instance_set.h"
#include "regraft/accel/kept_tree.h"

namespace regraft::accel {

/// The tree over everything, in world coordinates relative to `InstanceSet::origin`: over
/// instances (`two-level`) or over every triangle of every instance (`flat`).
class Tlas {
 public:
  /// Brings the tree in line with the instances. `placed.set_changed`: other primitives than
  /// before.
  TreeWork update(const Scene& scene, const InstanceSet& instances,
                  const InstanceSet::Changes& placed, Layout layout, const Tending& how,
                  Executor& executor);

  Aabb bounds() const { return tree_.bounds(); }
  const KeptTree& tree() const { return tree_; }
  const bvh::Bvh& bvh() const { return tree_.bvh(); }
  /// Expected tests of a ray that hits the scene's box, down through the instances' trees.
  double sah_cost(const InstanceSet& instances) const;
  /// The same for what rays entered of late, where the trees know it.
  double culling_efficiency(const InstanceSet& instances) const;
  /// The same if no tree had worn since its last build.
  double unworn_cost(const InstanceSet& instances) const;

  /// Fills the top tree's part of the view.
  void show(trace::TraceView& view) const;
  std::size_t bytes() const;
  std::string validate() const;

 private:
  bvh::BinnedSahBuilder::Config builder() const;
  bool holds_all() const;
  Aabb box_of(const Scene& scene, const InstanceSet& instances, std::uint32_t prim) const;
  void measure(const Scene& scene, const InstanceSet& instances, std::size_t instance,
               Executor& executor);
  Motion measure_moved(const Scene& scene, const InstanceSet& instances,
                       const InstanceSet::Changes& placed, Executor& executor);
  bool list_moved(const InstanceSet& instances, std::size_t instance, bool as_a_whole);
  void collect_primitives(const Scene& scene, const InstanceSet& instances, Executor& executor);
  void list_boxed();
  bool edit(const Scene& scene, const InstanceSet& instances, const InstanceSet::Changes& placed,
            const Tending& how, Executor& executor, TreeWork& work);
  void weigh(const InstanceSet& instances);
  double cost_through(const InstanceSet& instances,
                      const std::function<double(const Blas&)>& cost) const;

  Layout layout_ = Layout::two_level;
  KeptTree tree_;
  std::vector<Aabb> boxes_;
  std::vector<trace::FlatPrim> flat_;
  /// Where each instance's primitives begin, and the end of the last.
  std::vector<std::uint32_t> begin_;
  /// Those with a box, ascending: they are in the tree.
  std::vector<std::uint32_t> ids_;
  std::vector<std::uint32_t> moved_;  ///< primitives that moved in the last update, if few
};

}  // namespace regraft::accel
