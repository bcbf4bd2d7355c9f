#include "oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace regraft::test {

namespace {

struct Pair {
  double high, low;
};

/// Knuth's two-sum: high + low is a + b, exactly.
Pair two_sum(double a, double b) {
  const double high = a + b;
  const double part = high - a;
  return {high, (a - (high - part)) + (b - part)};
}

Pair two_product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}

/// Sign of the triple product in wide arithmetic, 0 where its rounding could matter.
int filtered_side(const Vec3r& d, const Vec3r& a, const Vec3r& b) {
  const Real det = dot(d, cross(a, b));
  const auto magnitude = [](const Vec3r& v) {
    return Vec3r{std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])};
  };
  const Vec3r p = magnitude(a), q = magnitude(b), r = magnitude(d);
  const Real sum = r[0] * (p[1] * q[2] + p[2] * q[1]) + r[1] * (p[2] * q[0] + p[0] * q[2]) +
                   r[2] * (p[0] * q[1] + p[1] * q[0]);
  // Two roundings in a and b, five above, each of half an ulp: less than 16 in all.
  const Real bound = 16 * std::numeric_limits<Real>::epsilon() * sum;
  return det > bound ? 1 : det < -bound ? -1 : 0;
}

Vec3r point(const Vec3d& p) {
  return {p.x, p.y, p.z};
}

Vec3r minus(const Vec3r& a, const Vec3r& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Real distance_to_segment(const Vec3r& p, const Vec3r& a, const Vec3r& b) {
  const Vec3r edge = minus(b, a);
  const Vec3r to = minus(p, a);
  const Real squared = dot(edge, edge);
  const Real t = squared > 0 ? std::clamp(dot(to, edge) / squared, Real(0), Real(1)) : Real(0);
  return length(minus(to, {t * edge[0], t * edge[1], t * edge[2]}));
}

/// What is left of v when its part along d is taken away.
Vec3r across(const Vec3r& v, const Vec3r& d) {
  const Real s = dot(v, d) / dot(d, d);
  return {v[0] - s * d[0], v[1] - s * d[1], v[2] - s * d[2]};
}

Verdict verdict_of(int u, int v, int w) {
  const bool negative = u < 0 || v < 0 || w < 0;
  const bool positive = u > 0 || v > 0 || w > 0;
  if (negative == positive) return Verdict::miss;
  return u == 0 || v == 0 || w == 0 ? Verdict::boundary : Verdict::hit;
}

}  // namespace

Real dot(const Vec3r& a, const Vec3r& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vec3r cross(const Vec3r& a, const Vec3r& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec3r subtract(const Vec3d& a, const Vec3d& b) {
  return {Real(a.x) - b.x, Real(a.y) - b.y, Real(a.z) - b.z};
}

Real length(const Vec3r& a) {
  return std::sqrt(dot(a, a));
}

Vec3r along(const Vec3d& o, Real t, const Vec3d& d) {
  return {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
}

Expansion::Expansion(double x) {
  add(x);
}

Expansion Expansion::difference(double a, double b) {
  Expansion e(a);
  e.add(-b);
  return e;
}

void Expansion::add(double x) {
  std::vector<double> parts;
  for (const double part : parts_) {
    const Pair sum = two_sum(x, part);
    if (sum.low != 0.0) parts.push_back(sum.low);
    x = sum.high;
  }
  if (x != 0.0) parts.push_back(x);
  parts_ = std::move(parts);
}

int Expansion::sign() const {
  return parts_.empty() ? 0 : parts_.back() > 0.0 ? 1 : -1;
}

Expansion Expansion::negated() const {
  Expansion e = *this;
  for (double& part : e.parts_) part = -part;
  return e;
}

Expansion operator+(const Expansion& a, const Expansion& b) {
  Expansion sum = a;
  for (const double part : b.parts_) sum.add(part);
  return sum;
}

Expansion operator*(const Expansion& a, const Expansion& b) {
  Expansion sum;
  for (const double x : a.parts_)
    for (const double y : b.parts_) {
      const Pair product = two_product(x, y);
      sum.add(product.low);
      sum.add(product.high);
    }
  return sum;
}

int side_of(const Vec3d& o, const Vec3d& d, const Vec3d& a, const Vec3d& b) {
  const int quick = filtered_side(point(d), subtract(a, o), subtract(b, o));
  if (quick != 0) return quick;
  Expansion sum;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const Expansion ai = Expansion::difference(a[i], o[i]), aj = Expansion::difference(a[j], o[j]);
    const Expansion bi = Expansion::difference(b[i], o[i]), bj = Expansion::difference(b[j], o[j]);
    sum = sum + Expansion(d[k]) * (ai * bj + (aj * bi).negated());
  }
  return sum.sign();
}

Judgement judge(const Vec3d& o, const Vec3d& d, const ExactTriangle& triangle) {
  const auto& [a, b, c] = triangle;
  Judgement j;
  j.verdict = verdict_of(side_of(o, d, b, c), side_of(o, d, c, a), side_of(o, d, a, b));
  const Vec3r way = point(d);
  const Vec3r pa = across(subtract(a, o), way), pb = across(subtract(b, o), way);
  const Vec3r pc = across(subtract(c, o), way);
  const Vec3r zero{};
  j.margin = std::min({distance_to_segment(zero, pa, pb), distance_to_segment(zero, pb, pc),
                       distance_to_segment(zero, pc, pa)});
  const Vec3r normal = cross(subtract(b, a), subtract(c, a));
  const Real across_plane = dot(normal, way);
  j.t = dot(normal, subtract(a, o)) / across_plane;
  const Real size = length(normal) * length(way);
  j.cosine = size > 0 ? std::fabs(across_plane) / size : 0;
  return j;
}

Real distance(const Vec3r& p, const ExactTriangle& triangle) {
  const auto& [a, b, c] = triangle;
  const Vec3r normal = cross(subtract(b, a), subtract(c, a));
  const Vec3d corners[3] = {a, b, c};
  const Real squared = dot(normal, normal);
  bool inside = squared > 0;
  Real nearest = std::numeric_limits<Real>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3r from = point(corners[k]), to = point(corners[(k + 1) % 3]);
    inside = inside && dot(cross(minus(to, from), minus(p, from)), normal) >= 0;
    nearest = std::min(nearest, distance_to_segment(p, from, to));
  }
  if (!inside) return nearest;
  return std::min(nearest, std::fabs(dot(normal, minus(p, point(a)))) / std::sqrt(squared));
}

}  // namespace regraft::test
