#pragma once

#include <vector>

#include "regraft/accel/blas.h"
#include "regraft/trace/late_tree.h"

namespace regraft::accel {

/// The update of a mesh's tree that waits for the first ray to come near: the very same as would
/// have been done at once, on the thread of that ray.
///
/// All that is given is used while rays are traced.
class LateUpdate final : public trace::LateTree {
 public:
  LateUpdate(Blas& blas, const Mesh& mesh, const Tending& how, Executor& executor)
      : blas_(blas), mesh_(mesh), how_(how), executor_(executor) {}

  /// Has `view` wait for the update, which will tell it of the tree's new arrays.
  void show_in(trace::InstanceView& view);

  /// What was done, and how long it took; after it `has_arrived`.
  const TreeWork& work() const { return work_; }
  double ms() const { return ms_; }
  /// True the first time after it `has_arrived`.
  bool is_news() { return has_arrived() && !std::exchange(is_told_, true); }

 private:
  void catch_up() override;

  Blas& blas_;
  const Mesh& mesh_;
  Tending how_;
  Executor& executor_;
  std::vector<trace::InstanceView*> views_;
  TreeWork work_;
  double ms_ = 0.0;
  bool is_told_ = false;
};

}  // namespace regraft::accel
