#include "regraft/kdtree/origin_integral.h"

#include <array>
#include <cmath>
#include <numbers>

namespace regraft::kdtree {
namespace {

constexpr double four_pi = 4.0 * std::numbers::pi;
/// N with all edges below this part of S: from here down quadrature is the more exact. Measured
/// against quadruple precision, boxes touching S: the closed form is off by 4e-10 of p at 2^-8, by
/// 4e-6 at 2^-14, 1e-2 at 2^-20; two Gauss points by 5e-4, 8e-6 and 1e-7.
constexpr double tiny_edge = 1.0 / 32768.0;

/// F(u, v, w), the fourfold antiderivative (twice in u, twice in v) of 1/r.
double corner_integral(double u, double v, double w) {
  const double u2 = u * u;
  const double v2 = v * v;
  const double w2 = w * w;
  const double r = std::sqrt(u2 + v2 + w2);
  if (r == 0.0) return 0.0;
  double sum = -r * (u2 + v2 - 2.0 * w2) / 6.0;
  // v + r cancels for negative v; (u² + w²)/(r − v) is the same.
  if (u2 + w2 > 0.0) sum += 0.5 * (u2 - w2) * v * std::log(v >= 0.0 ? v + r : (u2 + w2) / (r - v));
  if (v2 + w2 > 0.0) sum += 0.5 * (v2 - w2) * u * std::log(u >= 0.0 ? u + r : (v2 + w2) / (r - u));
  if (w != 0.0) sum -= u * v * w * std::atan2(u * v, w * r);
  return sum;
}

/// Where the antiderivative is taken along one side of a face, the first two negative.
std::array<double, 4> differences(const OriginSpace& s, int k) {
  return {s.lo[k], s.hi[k] - s.size[k], s.lo[k] - s.size[k], s.hi[k]};
}

/// ∫∫ 1/distance between the face of N across `axis` and the section of S `w` away from it.
double face_to_section(const OriginSpace& s, int axis, double w) {
  const std::array<double, 4> us = differences(s, (axis + 1) % 3);
  const std::array<double, 4> vs = differences(s, (axis + 2) % 3);
  double sum = 0.0;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const double f = corner_integral(us[a], vs[b], w);
      sum += (a < 2) == (b < 2) ? f : -f;
    }
  return sum;
}

/// Antiderivative in u and v of 1/r.
double point_integral(double u, double v, double w) {
  double sum = 0.0;
  if (u != 0.0) sum += u * std::asinh(v / std::sqrt(u * u + w * w));
  if (v != 0.0) sum += v * std::asinh(u / std::sqrt(v * v + w * w));
  if (w != 0.0) sum -= w * std::atan2(u * v, w * std::sqrt(u * u + v * v + w * w));
  return sum;
}

/// ∫ 1/distance between the point `p` and the section of S across `axis`, `w` away from it.
double point_to_section(const OriginSpace& s, int axis, const Vec3d& p, double w) {
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  const double u0 = -p[i];
  const double u1 = s.size[i] - p[i];
  const double v0 = -p[j];
  const double v1 = s.size[j] - p[j];
  return point_integral(u1, v1, w) - point_integral(u0, v1, w) - point_integral(u1, v0, w) +
         point_integral(u0, v0, w);
}

double gauss_faces(const OriginSpace& s, int axis, int points) {
  constexpr std::array<double, 2> gauss2{0.21132486540518713, 0.78867513459481287};
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  double sum = 0.0;
  for (int a = 0; a < points; ++a)
    for (int b = 0; b < points; ++b) {
      Vec3d p(0.0);
      p[i] = s.lo[i] + (points == 1 ? 0.5 : gauss2[a]) * (s.hi[i] - s.lo[i]);
      p[j] = s.lo[j] + (points == 1 ? 0.5 : gauss2[b]) * (s.hi[j] - s.lo[j]);
      const double touching = point_to_section(s, axis, p, 0.0);
      for (const double gap : {s.gap_below(axis), s.gap_above(axis)})
        if (gap > 0.0) sum += touching - point_to_section(s, axis, p, gap);
    }
  return sum / double(points * points);
}

bool tiny(const OriginSpace& s) {
  return s.hi.x - s.lo.x < tiny_edge && s.hi.y - s.lo.y < tiny_edge && s.hi.z - s.lo.z < tiny_edge;
}

}  // namespace

double face_probability(const OriginSpace& s, int points) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    if (const double area = s.face_area(axis); area > 0.0)
      sum += area * gauss_faces(s, axis, points);
  return (s.box_volume() + sum / four_pi) / s.volume();
}

double exact_probability(const OriginSpace& s) {
  if (tiny(s)) return face_probability(s, 2);
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (s.face_area(axis) <= 0.0) continue;
    const double touching = face_to_section(s, axis, 0.0);
    for (const double gap : {s.gap_below(axis), s.gap_above(axis)})
      if (gap > 0.0) sum += touching - face_to_section(s, axis, gap);
  }
  return (s.box_volume() + sum / four_pi) / s.volume();
}

}  // namespace regraft::kdtree
