#include "regraft/kdtree/event_bins.h"

namespace regraft::kdtree {

EventBins::EventBins(const Aabb& voxel, int count) : count_(count) {
  for (int k = 0; k < 3; ++k) {
    const double extent = double(voxel.hi[k]) - double(voxel.lo[k]);
    zero_[k] = voxel.lo[k];
    end_[k] = voxel.hi[k];
    scale_[k] = extent > 0.0 ? float(count / extent) : 0.0f;
    last_[k] = float(count - 1);
  }
}

bool EventBins::usable(const Aabb& voxel) {
  for (int k = 0; k < 3; ++k) {
    const double extent = double(voxel.hi[k]) - double(voxel.lo[k]);
    if (extent != 0.0 && !(extent > 1e-30 && extent < 1e30)) return false;
  }
  return true;
}

}  // namespace regraft::kdtree
