#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "regraft/scene/mesh.h"

namespace regraft::test {

/// A mesh that owns its arrays.
struct Geometry {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;

  MeshData data() const { return {vertices, triangles, {}, {}}; }
  Geometry& operator+=(const Geometry& other);
  /// Each vertex through `f`.
  Geometry mapped(const std::function<Vec3d(const Vec3d&)>& f) const;
  Geometry moved(const Vec3d& by) const;
  Geometry scaled(double by) const;
};

/// Random numbers that are the same on every machine and with every library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  std::uint64_t below(std::uint64_t n) { return engine_() % n; }
  /// In [lo, hi).
  double uniform(double lo, double hi) {
    return lo + (hi - lo) * (double(engine_() >> 11) * 0x1p-53);
  }
  Vec3d in_box(double half) {
    const double x = uniform(-half, half), y = uniform(-half, half);
    return {x, y, uniform(-half, half)};
  }
  /// Unit length, all ways alike.
  Vec3d way();

 private:
  std::mt19937_64 engine_;
};

Geometry triangle(const Vec3& a, const Vec3& b, const Vec3& c);
/// Closed; radius 1 about 0.
/// A turn and a place in a box at random.
Mat4d anyhow(Random& random, double reach);

Geometry sphere(std::uint32_t rings, std::uint32_t segments);
/// Closed; radii 1 and `tube` about the z axis.
Geometry torus(std::uint32_t rings, std::uint32_t segments, double tube);
/// Closed, 12 triangles.
Geometry box(const Vec3& lo, const Vec3& hi);
/// n × n squares on z = 0, from −half to half.
Geometry floor_grid(std::uint32_t n, float half);
/// Triangles of up to `size` anywhere in the cube of half width `half`.
Geometry soup(std::uint32_t count, std::uint64_t seed, double half, double size);
/// Long triangles of width `width` through the cube of half width `half`.
Geometry needles(std::uint32_t count, std::uint64_t seed, double half, double width);
/// n triangles round a hub at the origin, rising to height 0.25 at radius 1; closed by a floor.
Geometry closed_fan(std::uint32_t n);

}  // namespace regraft::test
