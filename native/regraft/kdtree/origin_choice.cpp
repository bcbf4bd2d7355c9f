#include "regraft/kdtree/origin_choice.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace regraft::kdtree {
namespace {

/// Of the pilot, left out at either end of every axis.
constexpr double outliers = 0.02;

/// From the lower to the upper quantile of the finite origins.
Aabb box_of_most(std::span<const Vec3> pilot) {
  Aabb box;
  std::vector<float> values;
  for (int k = 0; k < 3; ++k) {
    values.clear();
    for (const Vec3& origin : pilot)
      if (std::isfinite(origin[k])) values.push_back(origin[k]);
    if (values.empty()) return {};
    const std::size_t skip = std::size_t(outliers * double(values.size()));
    const auto low = values.begin() + std::ptrdiff_t(skip);
    const auto high = values.end() - 1 - std::ptrdiff_t(skip);
    std::nth_element(values.begin(), low, values.end());
    box.lo[k] = *low;
    std::nth_element(values.begin(), high, values.end());
    box.hi[k] = *high;
  }
  return box;
}

bool inside(const Aabb& box, const Vec3& p) {
  return box.contains({p, p});
}

}  // namespace

OriginChoice choose_origin_metric(std::span<const Vec3> pilot, const Aabb& scene,
                                  const Vec3& camera) {
  Aabb box = box_of_most(pilot);
  box.extend(camera);
  box = clipped(box, scene);
  const Vec3d extents = box.extents();
  const auto held = std::count_if(pilot.begin(), pilot.end(),
                                  [&box](const Vec3& origin) { return inside(box, origin); });
  const bool most = 2 * std::size_t(held) > pilot.size();
  const bool volume = extents.x > 0.0 && extents.y > 0.0 && extents.z > 0.0;
  if (!most || !volume || !inside(box, camera)) return {};
  return {OriginMetric::regions6, box};
}

}  // namespace regraft::kdtree
