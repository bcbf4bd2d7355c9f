#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "trace/bed.h"

namespace regraft::test {
namespace {

using accel::Layout;

/// Vertices and edge midpoints of a mesh, exactly as the tracer sees them but for the midpoints'
/// rounding to double.
std::vector<Vec3d> seams(const Geometry& g) {
  std::vector<Vec3d> points;
  for (const Vec3& v : g.vertices) points.emplace_back(v);
  for (const Triangle& t : g.triangles)
    for (int k = 0; k < 3; ++k)
      if (t[k] < t[(k + 1) % 3])
        points.push_back(0.5 * (Vec3d(g.vertices[t[k]]) + Vec3d(g.vertices[t[(k + 1) % 3]])));
  return points;
}

std::size_t lost(const Scene& scene, std::span<const Ray> rays) {
  std::size_t sum = 0;
  for (const Layout layout : {Layout::two_level, Layout::flat})
    for (const simd::Isa isa : simd::available_isas()) {
      accel::Accelerator accelerator;
      accel::UpdateOptions options;
      options.layout = layout;
      const int width = isa == simd::Isa::scalar || isa == simd::Isa::sse ? 4 : 8;
      accelerator.update(scene, scene.changes(), options, width, pool(2));
      const trace::Tracer tracer(accelerator.view(), isa);
      for (const Entry entry : entries)
        for (const Found& found : closest_hits(tracer, rays, entry)) sum += !found.hit();
    }
  return sum;
}

/// Rays of a closed mesh lost at vertices and edges, seen from points inside it and, if it is
/// convex, from outside.
std::size_t lost(const Geometry& g, const Mat4d& m, std::span<const Vec3d> inside, bool convex) {
  Scene scene;
  add(scene, g, m);
  const auto world = [&](const Vec3d& p) { return Vec3d(m * glm::dvec4(p, 1.0)); };
  std::vector<Ray> rays;
  std::size_t i = 0;
  for (const Vec3d& seam : seams(g)) {
    const Vec3d from = inside[i++ % inside.size()];
    const Vec3d beyond = from + 3.0 * (seam - from);
    rays.push_back({world(from), world(seam) - world(from)});
    if (convex) rays.push_back({world(beyond), world(seam) - world(beyond)});
  }
  return lost(scene, rays);
}

Mat4d scale(double s) {
  return glm::scale(Mat4d(1.0), Vec3d(s));
}

std::vector<Mat4d> placements() {
  const Mat4d one(1.0);
  const Mat4d turned = glm::rotate(one, 1.0, glm::normalize(Vec3d(1, 2, 3)));
  return {one,
          glm::translate(one, Vec3d(1e5, -1e5, 1e5)),
          scale(1e-4),
          scale(1e6),
          turned,
          glm::translate(one, Vec3d(1e5, 2e5, 3e5)) * turned,
          glm::scale(turned, Vec3d(1.0, 30.0, -0.01))};
}

TEST(Watertight, NoRayIsLostAtTheSeamsOfASphere) {
  const Vec3d inside[] = {{0, 0, 0}, {0.3, -0.2, 0.1}, {-0.4, 0.4, 0.4}, {0, 0, 0.5}};
  for (const Mat4d& m : placements()) EXPECT_EQ(lost(sphere(12, 17), m, inside, true), 0u);
}

TEST(Watertight, NoRayIsLostAtTheSeamsOfATorus) {
  std::vector<Vec3d> inside;
  for (int i = 0; i < 7; ++i) inside.emplace_back(std::cos(i), std::sin(i), 0.1);
  for (const Mat4d& m : placements()) EXPECT_EQ(lost(torus(17, 13, 0.4), m, inside, false), 0u);
}

TEST(Watertight, NoRayIsLostWhereVerticesLieFarFromTheOrigin) {
  for (const double off : {1e3, 1e5}) {
    const Vec3d center(off, -off, off);
    const Vec3d inside[] = {center, center + Vec3d(0.3, -0.2, 0.1), center - Vec3d(0.2, 0.2, 0.2)};
    EXPECT_EQ(lost(sphere(8, 11).moved(center), Mat4d(1.0), inside, true), 0u) << off;
  }
}

TEST(Watertight, NoRayIsLostOnAMeshOfManyTinyTriangles) {
  const Geometry g = sphere(120, 120);
  Scene scene;
  add(scene, g);
  Random random(1);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < g.vertices.size(); i += 7) {
    const Vec3d from = 0.5 * random.in_box(1.0);
    rays.push_back({from, Vec3d(g.vertices[i]) - from});
  }
  EXPECT_EQ(lost(scene, rays), 0u);
}

TEST(Watertight, NoRayIsLostBetweenBoxesThatTouch) {
  // The walls between cells are made of two coincident faces.
  Geometry cells;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      cells += box({float(x), float(y), 0}, {float(x) + 1, float(y) + 1, 1});
  Scene scene;
  add(scene, cells);
  Random random(2);
  std::vector<Ray> rays;
  for (const Vec3d& seam : seams(cells)) {
    const Vec3d from = Vec3d(1.5, 1.5, 0.5) + 0.4 * random.in_box(1.0);
    rays.push_back({from, seam - from});
    Ray along{Vec3d(seam.x, seam.y, 0.5), {0, 0, random.below(2) == 0 ? 1.0 : -1.0}};
    rays.push_back(along);
  }
  EXPECT_EQ(lost(scene, rays), 0u);
}

TEST(Watertight, NoRayIsLostOnceTheMeshHasMovedUnderRefit) {
  const Geometry g = sphere(10, 14);
  Bed bed;
  const std::uint32_t mesh = bed.add(g);
  ASSERT_EQ(bed.update(), "");
  const Geometry twisted = g.mapped([](const Vec3d& v) {
    const double a = 2.5 * v.z;
    return Vec3d(v.x * std::cos(a) - v.y * std::sin(a), v.x * std::sin(a) + v.y * std::cos(a),
                 1.5 * v.z);
  });
  bed.deform(mesh, twisted);
  ASSERT_EQ(bed.update(), "");
  std::vector<Ray> rays;
  for (const Vec3d& seam : seams(twisted))
    rays.push_back({{0.05, 0.1, 0.2}, seam - Vec3d(0.05, 0.1, 0.2)});
  EXPECT_EQ(bed.differences(rays), "");
  for (const Found& found : bed.hits(rays)) EXPECT_TRUE(found.hit());
}

}  // namespace
}  // namespace regraft::test
