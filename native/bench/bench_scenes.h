#pragma once

// Meshes that every native benchmark uses; made by formula, the same on every machine.

#include <cmath>
#include <random>
#include <vector>

#include "regraft/scene/mesh.h"

namespace regraft::bench {

inline constexpr double pi = 3.14159265358979323846;

struct Triangles {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// A waving sheet of about `count` triangles, 2 units wide: large smooth surfaces. `time` moves
/// every vertex.
inline Triangles sheet(std::size_t count, float time) {
  const auto n = std::uint32_t(std::sqrt(double(count) / 2.0));
  Triangles mesh;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const float x = 2.0f * float(i) / float(n) - 1.0f, y = 2.0f * float(j) / float(n) - 1.0f;
      mesh.vertices.emplace_back(x, y, 0.2f * std::sin(5.0f * x + time) * std::cos(4.0f * y));
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + n + 1;
      mesh.triangles.emplace_back(a, a + 1, b);
      mesh.triangles.emplace_back(a + 1, b + 1, b);
    }
  return mesh;
}

/// About `count` triangles in chunks of 48 that fly apart: incoherent, smaller than pixels.
inline Triangles chunks(std::size_t count, float time) {
  constexpr std::uint32_t per_chunk = 48;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  Triangles mesh;
  for (std::size_t c = 0; c < count / per_chunk; ++c) {
    const Vec3 home(uniform(random), uniform(random), uniform(random));
    const Vec3 center = home * (0.3f + time);
    for (std::uint32_t t = 0; t < per_chunk; ++t) {
      const auto first = std::uint32_t(mesh.vertices.size());
      for (int k = 0; k < 3; ++k)
        mesh.vertices.push_back(center +
                                0.02f * Vec3(uniform(random), uniform(random), uniform(random)));
      mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
  }
  return mesh;
}

/// A closed sphere of about `count` triangles, radius 1 about the origin.
inline Triangles sphere(std::size_t count) {
  const auto rings = std::uint32_t(std::sqrt(double(count) / 4.0)), segments = 2 * rings;
  Triangles mesh;
  mesh.vertices.emplace_back(0.0f, 0.0f, 1.0f);
  for (std::uint32_t r = 1; r < rings; ++r)
    for (std::uint32_t s = 0; s < segments; ++s) {
      const double a = pi * r / rings, b = 2.0 * pi * s / segments;
      mesh.vertices.emplace_back(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
    }
  mesh.vertices.emplace_back(0.0f, 0.0f, -1.0f);
  const auto last = std::uint32_t(mesh.vertices.size() - 1);
  for (std::uint32_t s = 0; s < segments; ++s) {
    const std::uint32_t next = (s + 1) % segments;
    mesh.triangles.emplace_back(0, 1 + s, 1 + next);
    for (std::uint32_t r = 0; r + 2 < rings; ++r) {
      const std::uint32_t a = 1 + r * segments, b = a + segments;
      mesh.triangles.emplace_back(a + s, b + s, b + next);
      mesh.triangles.emplace_back(a + s, b + next, a + next);
    }
    const std::uint32_t a = 1 + (rings - 2) * segments;
    mesh.triangles.emplace_back(a + s, last, a + next);
  }
  return mesh;
}

/// About `count` triangles: a floor with rows of finely meshed balls on it, near and far.
inline Triangles balls(std::size_t count) {
  const Triangles one = sphere(count / 400);
  Triangles mesh;
  for (int j = 0; j < 20; ++j)
    for (int i = 0; i < 20; ++i) {
      const auto first = std::uint32_t(mesh.vertices.size());
      const Vec3 center(0.2f * float(i) - 1.9f, 0.3f * float(j) - 1.9f, 0.0f);
      for (const Vec3& v : one.vertices) mesh.vertices.push_back(center + 0.09f * v);
      for (const Triangle& t : one.triangles) mesh.triangles.push_back(t + first);
    }
  const auto first = std::uint32_t(mesh.vertices.size());
  for (const float y : {-9.0f, 9.0f})
    for (const float x : {-9.0f, 9.0f}) mesh.vertices.emplace_back(x, y, -0.1f);
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first + 1, first + 3, first + 2);
  return mesh;
}

/// 0: sheet, 1: chunks.
inline Triangles make(std::int64_t kind, std::int64_t count, float time) {
  return kind == 0 ? sheet(std::size_t(count), time) : chunks(std::size_t(count), time);
}

/// Direction from the eye at (0, −3, 1.5) through a point, in pixels, of a square image of `size`.
inline Vec3d eye() {
  return {0.0, -3.0, 1.5};
}
inline Vec3d pixel_direction(double x, double y, int size) {
  const double u = x / size - 0.5, v = y / size - 0.5;
  return {u * 0.8, 0.894 - 0.447 * v * 0.8, -0.447 - 0.894 * -v * 0.8};
}

}  // namespace regraft::bench
