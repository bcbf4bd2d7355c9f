#include "regraft/kdtree/solid_angle.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace regraft::kdtree {
namespace {

/// The face of [lo, hi] across `axis` at `height`, all relative to the eye.
double face_solid_angle(const Vec3d& lo, const Vec3d& hi, int axis, double height) {
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  const auto corner = [&](double u, double v) {
    Vec3d p(0.0);
    p[axis] = height;
    p[i] = u;
    p[j] = v;
    return p;
  };
  const Vec3d a = corner(lo[i], lo[j]);
  const Vec3d c = corner(hi[i], hi[j]);
  return triangle_solid_angle(a, corner(hi[i], lo[j]), c) +
         triangle_solid_angle(a, c, corner(lo[i], hi[j]));
}

}  // namespace

double triangle_solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double la = glm::length(a);
  const double lb = glm::length(b);
  const double lc = glm::length(c);
  const double numerator = std::fabs(glm::dot(a, glm::cross(b - a, c - a)));
  const double denominator =
      la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
  return 2.0 * std::atan2(numerator, denominator);
}

double box_solid_angle(const Vec3d& lo, const Vec3d& hi, const Vec3d& eye) {
  bool outside = false;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const bool below = eye[k] < lo[k];
    if (!below && eye[k] <= hi[k]) continue;
    outside = true;
    sum += face_solid_angle(lo - eye, hi - eye, k, (below ? lo[k] : hi[k]) - eye[k]);
  }
  return outside ? sum : 4.0 * std::numbers::pi;
}

}  // namespace regraft::kdtree
