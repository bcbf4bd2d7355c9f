#pragma once

#include <array>
#include <vector>

#include "regraft/core/vec.h"

namespace regraft::test {

/// Wider than anything under test: 64 bits of mantissa on x86-64.
using Real = long double;
using Vec3r = std::array<Real, 3>;

/// A sum of doubles that is exact: components do not overlap, smallest first, none is zero
/// (Shewchuk, Adaptive Precision Floating-Point Arithmetic, Discrete & Computational Geometry 18,
/// 1997). Exact as long as no product underflows or overflows a double.
class Expansion {
 public:
  Expansion() = default;
  explicit Expansion(double x);
  /// a − b.
  static Expansion difference(double a, double b);

  int sign() const;
  Expansion negated() const;
  friend Expansion operator+(const Expansion& a, const Expansion& b);
  friend Expansion operator*(const Expansion& a, const Expansion& b);

 private:
  void add(double x);
  std::vector<double> parts_;
};

/// Sign of d · ((a − o) × (b − o)): on which side of the directed line o + t·d the directed edge
/// a b passes. Exact.
int side_of(const Vec3d& o, const Vec3d& d, const Vec3d& a, const Vec3d& b);

struct ExactTriangle {
  Vec3d a, b, c;
};

enum class Verdict { miss, boundary, hit };

/// What exact arithmetic has to say of the whole line o + t·d, −∞ < t < ∞, and a triangle.
struct Judgement {
  /// Seen along the line, which is inside the triangle, on an edge or vertex of it, or outside. A
  /// triangle seen edge-on has no inside.
  Verdict verdict = Verdict::miss;
  /// Seen along the line, distance of the line from the nearest edge; world units.
  Real margin = 0;
  /// Where the line meets the triangle's plane; NaN if they are parallel.
  Real t = 0;
  /// |cosine| of the angle between line and normal.
  Real cosine = 0;
};
Judgement judge(const Vec3d& o, const Vec3d& d, const ExactTriangle& triangle);

/// Distance of a point from a triangle, a line or point if it has no area.
Real distance(const Vec3r& p, const ExactTriangle& triangle);

Real dot(const Vec3r& a, const Vec3r& b);
Vec3r cross(const Vec3r& a, const Vec3r& b);
Vec3r subtract(const Vec3d& a, const Vec3d& b);
Real length(const Vec3r& a);
/// o + t·d.
Vec3r along(const Vec3d& o, Real t, const Vec3d& d);

}  // namespace regraft::test
