#include "regraft/trace/point_triangle.h"

#include <glm/geometric.hpp>

namespace regraft::trace {

namespace {

using glm::dot;
using Weights = glm::dvec2;

/// Share of the way from a to b that is nearest, given the projections of the point on a→b as
/// seen from either end.
double along(double from_a, double from_b) {
  return from_a == from_b ? 0.0 : from_a / (from_a - from_b);
}

}  // namespace

Weights nearest_weights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a;
  const double a1 = dot(ab, p - a), a2 = dot(ac, p - a);
  if (a1 <= 0.0 && a2 <= 0.0) return {0.0, 0.0};
  const double b1 = dot(ab, p - b), b2 = dot(ac, p - b);
  if (b1 >= 0.0 && b2 <= b1) return {1.0, 0.0};
  const double vc = a1 * b2 - b1 * a2;
  if (vc <= 0.0 && a1 >= 0.0 && b1 <= 0.0) return {along(a1, b1), 0.0};
  const double c1 = dot(ab, p - c), c2 = dot(ac, p - c);
  if (c2 >= 0.0 && c1 <= c2) return {0.0, 1.0};
  const double vb = c1 * a2 - a1 * c2;
  if (vb <= 0.0 && a2 >= 0.0 && c2 <= 0.0) return {0.0, along(a2, c2)};
  const double va = b1 * c2 - c1 * b2;
  if (va <= 0.0 && b2 - b1 >= 0.0 && c1 - c2 >= 0.0) {
    const double w = along(b2 - b1, c2 - c1);
    return {1.0 - w, w};
  }
  const double sum = va + vb + vc;
  return {vb / sum, vc / sum};
}

}  // namespace regraft::trace
