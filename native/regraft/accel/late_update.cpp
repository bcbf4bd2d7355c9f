#include "regraft/accel/late_update.h"

#include <chrono>

namespace regraft::accel {

void LateUpdate::show_in(trace::InstanceView& view) {
  view.mesh.late = this;
  views_.push_back(&view);
}

void LateUpdate::catch_up() {
  const auto start = std::chrono::steady_clock::now();
  work_ = blas_.update(mesh_, false, Layout::two_level, how_, executor_);
  const trace::MeshView now = blas_.view(mesh_);
  // Nothing else: other threads are reading the rest to find out whether they come near.
  for (trace::InstanceView* view : views_) {
    view->mesh.nodes = now.nodes;
    view->mesh.entered = now.entered;
    view->mesh.prim_ids = now.prim_ids;
    view->mesh.prim_count = now.prim_count;
    view->mesh.refitted = now.refitted;
  }
  ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace regraft::accel
