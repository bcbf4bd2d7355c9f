#pragma once

#include <span>
#include <string>
#include <vector>

#include "oracle.h"
#include "regraft/scene/scene.h"
#include "trace/geometry.h"
#include "trace/rays.h"

namespace regraft::test {

/// A triangle of the scene that rays can meet, in world space.
struct WorldTriangle {
  ExactTriangle corners;
  std::uint32_t instance;
  std::uint32_t prim;
  /// Largest coordinate a vertex has on its way from object to world space: its rounding there is
  /// not the tracer's fault.
  Real magnitude;
  /// A ball that holds the triangle, to leave out cheaply what a line passes by.
  Vec3d center;
  double radius;
};

/// Judges hits in the world by exact arithmetic, knowing nothing of trees, frames or floats.
///
/// Rays are traced in floats, so a ray may be taken for one that passes `ulps` units in the last
/// place of the largest coordinate beside it. What lies clear of that must be right.
class SceneOracle {
 public:
  explicit SceneOracle(const Scene& scene, double ulps = 16.0);

  /// What is wrong with the answer `found`, or "".
  std::string complaint(const Ray& ray, const Found& found) const;

  /// The nearest triangle, if every triangle on the way is passed `margin` clear of its edges;
  /// otherwise null.
  const WorldTriangle* surely_nearest(const Ray& ray, double margin) const;

  std::span<const WorldTriangle> triangles() const { return triangles_; }
  const Vec3d& center() const { return center_; }
  /// Of a ball about the centre that holds all triangles.
  double radius() const { return radius_; }

 private:
  Real tolerance(const Ray& ray, Real magnitude) const;
  std::string unsound(const Ray& ray, const Found& found) const;
  std::string missed(const Ray& ray, const Found& found) const;

  std::vector<WorldTriangle> triangles_;
  Vec3d center_{0.0};
  double radius_ = 0.0;
  Real relative_;
};

/// Rays meant to go wrong: through vertices, along and through edges, in the planes of boxes and
/// triangles, parallel to axes with zeros of both signs, from inside, outside and off the
/// surface, with directions of all lengths.
std::vector<Ray> nasty_rays(const SceneOracle& oracle, std::uint64_t seed, std::size_t count);

}  // namespace regraft::test
