#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "regraft/accel/blas.h"
#include "regraft/accel/instance_set.h"
#include "regraft/bvh/refit.h"
#include "regraft/bvh/wide_bvh.h"

namespace regraft::accel {

/// The tree over everything, in world coordinates relative to `InstanceSet::origin`: over
/// instances (`two-level`) or over every triangle of every instance (`flat`).
class Tlas {
 public:
  /// Brings the tree in line with the instances. `moved`: some box changed; `set_changed`: other
  /// primitives than before.
  TreeWork update(const Scene& scene, const InstanceSet& instances, Layout layout, bool set_changed,
                  bool moved, Policy policy, int width, Executor& executor);

  Aabb bounds() const { return bvh_.bounds(); }
  const bvh::Bvh& bvh() const { return bvh_; }
  /// Expected tests of a ray that hits the scene's box, down through the instances' trees.
  double sah_cost(const InstanceSet& instances) const;
  /// The same if no tree had worn since its last build.
  double unworn_cost(const InstanceSet& instances) const;

  /// Fills the top tree's part of the view.
  void show(trace::TraceView& view) const;
  std::size_t bytes() const;
  std::string validate() const;

 private:
  bvh::RefitResult refit(Executor& executor);
  bool holds_all() const;
  void measure(const Scene& scene, const InstanceSet& instances, Executor& executor);
  void collect_primitives(const Scene& scene, const InstanceSet& instances, Executor& executor);
  double cost_through(const InstanceSet& instances, bool unworn) const;

  Layout layout_ = Layout::two_level;
  bvh::Bvh bvh_;
  bvh::WideBvh wide_;
  std::vector<Aabb> boxes_;
  std::vector<trace::FlatPrim> flat_;
  /// Those with a box, ascending: they are in the tree.
  std::vector<std::uint32_t> ids_;
  bvh::RefitResult now_;
  bvh::RefitResult built_;
  bool exists_ = false;
};

}  // namespace regraft::accel
