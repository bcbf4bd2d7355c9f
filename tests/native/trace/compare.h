#pragma once

#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "regraft/accel/accelerator.h"
#include "regraft/scene/scene.h"
#include "trace/geometry.h"
#include "trace/rays.h"

namespace regraft::test {

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

/// A pool of so many threads, made once.
Executor& pool(unsigned threads);

std::uint32_t add_mesh(Scene& scene, const Geometry& g, const std::string& name = "");
std::uint32_t add_instance(Scene& scene, std::uint32_t mesh, const Mat4d& m = Mat4d(1.0));
/// A mesh and one instance of it; returns the mesh's id.
std::uint32_t add(Scene& scene, const Geometry& g, const Mat4d& m = Mat4d(1.0));

/// Hits by brute force over a scene whose trees are built anew.
std::vector<Found> hits_anew(const Scene& scene, std::span<const Ray> rays);

/// Asks every instruction set that reads nodes of `width`, and both entries, for the closest and
/// for any hit of `rays`.
/// @return the first answer that differs from `wanted` in any bit, in words, or "".
std::string difference(const trace::TraceView& view, int width, std::span<const Ray> rays,
                       std::span<const Found> wanted);

/// A ray whose interval ends at, just before or just behind the hit found without it, and what
/// is to be found then.
struct Interval {
  Ray ray;
  enum Wanted { same, nothing, later } wanted;
  Found before;

  bool right(const Found& found) const;
};
std::vector<Interval> tight_intervals(std::span<const Ray> rays, std::span<const Found> hits);

}  // namespace regraft::test
