#include "regraft/accel/vertex_bounds.h"

#include <atomic>
#include <cstddef>
#include <limits>
#include <vector>

namespace regraft::accel {

namespace {

constexpr std::size_t grain = 16384;
/// Coordinates looked at together: four points, so that each lane sees one axis only.
constexpr std::size_t lanes = 12;

struct LaneBounds {
  float lo[lanes];
  float hi[lanes];
  float zero[lanes];  ///< NaN where something was not finite

  LaneBounds() {
    for (std::size_t i = 0; i < lanes; ++i) {
      lo[i] = std::numeric_limits<float>::infinity();
      hi[i] = -lo[i];
      zero[i] = 0.0f;
    }
  }
  void extend(const float* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const float x = values[i];
      lo[i] = x < lo[i] ? x : lo[i];
      hi[i] = x > hi[i] ? x : hi[i];
      zero[i] += x - x;
    }
  }
  bool is_finite() const {
    for (const float z : zero)
      if (z != 0.0f) return false;
    return true;
  }
  Aabb box() const {
    Aabb box;
    for (std::size_t i = 0; i < lanes; i += 3)
      box.extend({Vec3(lo[i], lo[i + 1], lo[i + 2]), Vec3(hi[i], hi[i + 1], hi[i + 2])});
    return box;
  }
};

}  // namespace

std::optional<Aabb> vertex_bounds(std::span<const Vec3> vertices, Executor& executor) {
  std::vector<Aabb> boxes((vertices.size() + grain - 1) / grain);
  std::atomic<bool> is_finite{true};
  executor.parallel_for(vertices.size(), grain, [&](std::size_t begin, std::size_t end) {
    LaneBounds bounds;
    const float* at = &vertices[begin].x;
    const float* const last = at + 3 * (end - begin);
    for (; at + lanes <= last; at += lanes) bounds.extend(at, lanes);
    bounds.extend(at, std::size_t(last - at));
    if (!bounds.is_finite()) is_finite.store(false, std::memory_order_relaxed);
    boxes[begin / grain] = bounds.box();
  });
  if (!is_finite) return {};
  Aabb all;
  for (const Aabb& box : boxes) all.extend(box);
  return all;
}

}  // namespace regraft::accel
