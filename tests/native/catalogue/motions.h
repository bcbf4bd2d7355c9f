#pragma once

#include <cmath>
#include <cstddef>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "trace/bed.h"

namespace regraft::test {

/// A frame and its time: frames times the time step.
struct Moment {
  int frame = 0;
  double time = 0.0;

  bool odd() const { return frame % 2 == 1; }
};

/// Where the `i`-th of many things is.
using Motion = Vec3d (*)(std::size_t i, const Moment& now);

inline Vec3d in_a_grid(std::size_t i) {
  return {double(i % 8), double(i / 8 % 8), double(i / 64)};
}

inline Vec3d anywhere(std::size_t i, std::uint64_t seed, double half) {
  Random random(seed * 7919 + i);
  return random.in_box(half);
}

/// One small triangle at each place.
inline Geometry shards(std::size_t count, Motion motion, const Moment& now) {
  Geometry g;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d at = motion(i, now);
    const auto first = std::uint32_t(g.vertices.size());
    for (const Vec3d& corner : {Vec3d(0, 0, 0), Vec3d(0.3, 0.1, 0), Vec3d(0, 0.2, 0.3)})
      g.vertices.emplace_back(at + corner);
    g.triangles.emplace_back(first, first + 1, first + 2);
  }
  return g;
}

/// A mesh that moves at time steps ×1, ×10 and ×100, kept by every policy: at every frame all
/// trees are valid and answer as brute force over a scene built anew does, which exact arithmetic
/// finds right.
/// @return the first problem, or "".
template <typename Pose>
std::string problems_in_motion(const Pose& pose, int frames = 4) {
  for (const double step : {1.0, 10.0, 100.0}) {
    Bed bed(policies());
    const std::uint32_t mesh = bed.add(pose(Moment{}));
    for (int frame = 0; frame <= frames; ++frame) {
      bed.deform(mesh, pose(Moment{frame, frame * step}));
      bed.note_rays(100'000'000);
      std::string error = bed.update();
      const std::vector<Ray> rays =
          nasty_rays(SceneOracle(bed.scene), std::uint64_t(frame), error.empty() ? 16 : 0);
      if (error.empty()) error = bed.differences(rays);
      if (error.empty()) error = bed.complaints(rays);
      if (!error.empty()) return text("frame ", frame, " at step ", step, ": ", error);
    }
  }
  return "";
}

}  // namespace regraft::test
