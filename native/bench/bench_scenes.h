#pragma once

// Meshes that every native benchmark uses; made by formula, the same on every machine.

#include <cmath>
#include <random>
#include <vector>

#include "regraft/scene/mesh.h"

namespace regraft::bench {

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

/// 0: sheet, 1: chunks.
inline Triangles make(std::int64_t kind, std::int64_t count, float time) {
  return kind == 0 ? sheet(std::size_t(count), time) : chunks(std::size_t(count), time);
}

/// Direction from the eye at (0, −3, 1.5) through a pixel of a square image of `size`.
inline Vec3d eye() {
  return {0.0, -3.0, 1.5};
}
inline Vec3d pixel_direction(int x, int y, int size) {
  const double u = (x + 0.5) / size - 0.5, v = (y + 0.5) / size - 0.5;
  return {u * 0.8, 0.894 - 0.447 * v * 0.8, -0.447 - 0.894 * -v * 0.8};
}

}  // namespace regraft::bench
