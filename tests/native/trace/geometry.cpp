#include "trace/geometry.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace regraft::test {

namespace {

using std::numbers::pi;

/// Two triangles for each cell of a grid that is closed on itself in both directions.
void wrap_cells(Geometry& g, std::uint32_t rings, std::uint32_t segments) {
  for (std::uint32_t r = 0; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const auto at = [&](std::uint32_t i, std::uint32_t j) {
        return (r + i) % rings * segments + (s + j) % segments;
      };
      g.triangles.push_back({at(0, 0), at(1, 0), at(1, 1)});
      g.triangles.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
}

}  // namespace

Geometry& Geometry::operator+=(const Geometry& other) {
  const auto shift = std::uint32_t(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles) triangles.push_back(t + shift);
  return *this;
}

Geometry Geometry::mapped(const std::function<Vec3d(const Vec3d&)>& f) const {
  Geometry g = *this;
  for (Vec3& v : g.vertices) v = Vec3(f(Vec3d(v)));
  return g;
}

Geometry Geometry::moved(const Vec3d& by) const {
  return mapped([&](const Vec3d& v) { return v + by; });
}

Geometry Geometry::scaled(double by) const {
  return mapped([&](const Vec3d& v) { return v * by; });
}

Vec3d Random::way() {
  for (;;) {
    const Vec3d v = in_box(1.0);
    const double length = glm::length(v);
    if (length > 0.1 && length < 1.0) return v / length;
  }
}

Geometry triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{a, b, c}, {{0, 1, 2}}};
}

Mat4d anyhow(Random& random, double reach) {
  return glm::rotate(glm::translate(Mat4d(1.0), random.in_box(reach)), random.uniform(0.0, 6.0),
                     random.way());
}

Geometry sphere(std::uint32_t rings, std::uint32_t segments) {
  Geometry g;
  g.vertices = {{0, 0, 1}, {0, 0, -1}};
  for (std::uint32_t r = 1; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const double a = pi * r / rings, b = 2 * pi * s / segments;
      g.vertices.emplace_back(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
    }
  const auto at = [&](std::uint32_t r, std::uint32_t s) { return 2 + (r - 1) * segments + s; };
  for (std::uint32_t s = 0; s < segments; ++s) {
    const std::uint32_t n = (s + 1) % segments;
    g.triangles.push_back({0, at(1, s), at(1, n)});
    g.triangles.push_back({1, at(rings - 1, n), at(rings - 1, s)});
    for (std::uint32_t r = 1; r + 1 < rings; ++r) {
      g.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, n)});
      g.triangles.push_back({at(r, s), at(r + 1, n), at(r, n)});
    }
  }
  return g;
}

Geometry torus(std::uint32_t rings, std::uint32_t segments, double tube) {
  Geometry g;
  for (std::uint32_t r = 0; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const double a = 2 * pi * r / rings, b = 2 * pi * s / segments;
      const double out = 1 + tube * std::cos(b);
      g.vertices.emplace_back(out * std::cos(a), out * std::sin(a), tube * std::sin(b));
    }
  wrap_cells(g, rings, segments);
  return g;
}

Geometry box(const Vec3& lo, const Vec3& hi) {
  Geometry g;
  for (unsigned i = 0; i < 8; ++i)
    g.vertices.emplace_back((i & 1u) != 0 ? hi.x : lo.x, (i & 2u) != 0 ? hi.y : lo.y,
                            (i & 4u) != 0 ? hi.z : lo.z);
  g.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return g;
}

Geometry floor_grid(std::uint32_t n, float half) {
  Geometry g;
  for (std::uint32_t y = 0; y <= n; ++y)
    for (std::uint32_t x = 0; x <= n; ++x)
      g.vertices.emplace_back(half * (2.0f * float(x) / float(n) - 1.0f),
                              half * (2.0f * float(y) / float(n) - 1.0f), 0.0f);
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x, b = a + n + 1;
      g.triangles.push_back({a, a + 1, b + 1});
      g.triangles.push_back({a, b + 1, b});
    }
  return g;
}

Geometry soup(std::uint32_t count, std::uint64_t seed, double half, double size) {
  Random random(seed);
  Geometry g;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3d at = random.in_box(half);
    g += triangle(Vec3(at + random.in_box(size)), Vec3(at + random.in_box(size)),
                  Vec3(at + random.in_box(size)));
  }
  return g;
}

Geometry needles(std::uint32_t count, std::uint64_t seed, double half, double width) {
  Random random(seed);
  Geometry g;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3d from = random.in_box(half), to = random.in_box(half);
    const Vec3d middle = 0.5 * (from + to) + random.in_box(width);
    g += triangle(Vec3(from), Vec3(to), Vec3(middle));
  }
  return g;
}

Geometry closed_fan(std::uint32_t n) {
  Geometry g;
  g.vertices = {{0, 0, 0.25f}, {0, 0, -1}};
  for (std::uint32_t s = 0; s < n; ++s)
    g.vertices.emplace_back(std::cos(2 * pi * s / n), std::sin(2 * pi * s / n), 0.0f);
  for (std::uint32_t s = 0; s < n; ++s) {
    const std::uint32_t a = 2 + s, b = 2 + (s + 1) % n;
    g.triangles.push_back({0, a, b});
    g.triangles.push_back({1, b, a});
  }
  return g;
}

}  // namespace regraft::test
