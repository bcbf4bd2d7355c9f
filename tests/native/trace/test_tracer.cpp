#include "regraft/trace/tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "trace/bed.h"
#include "trace/brute_force.h"

namespace regraft::test {
namespace {

Mat4d at(const Vec3d& p) {
  return glm::translate(Mat4d(1.0), p);
}

TEST(Tracer, ClosedMeshesAreTheSameForAllAndRight) {
  Bed bed;
  bed.add(sphere(8, 12));
  bed.add(torus(10, 8, 0.4), at({0, 0, 1}));
  EXPECT_EQ(bed.problems(), "");
}

TEST(Tracer, ASoupIsTheSameForAllAndRight) {
  Bed bed;
  bed.add(soup(200, 2, 1.0, 0.3));
  EXPECT_EQ(bed.problems(2, 256), "");
}

TEST(Tracer, InstancesTurnedAndMovedAreTheSameForAllAndRight) {
  Bed bed;
  Random random(3);
  const std::uint32_t mesh = add_mesh(bed.scene, soup(60, 3, 1.0, 0.3));
  for (int i = 0; i < 6; ++i) add_instance(bed.scene, mesh, anyhow(random, 2.0));
  EXPECT_EQ(bed.problems(3, 256), "");
}

TEST(Tracer, InstancesShearedMirroredAndSquashedAreTheSameForAllAndRight) {
  Bed bed;
  Random random(4);
  const std::uint32_t mesh = add_mesh(bed.scene, soup(60, 4, 1.0, 0.3));
  for (int i = 0; i < 6; ++i) {
    Mat4d m = anyhow(random, 2.0);
    m[1] += random.uniform(-2.0, 2.0) * m[0];
    m[2] *= random.uniform(-2.0, 0.5);
    add_instance(bed.scene, mesh, m);
  }
  EXPECT_EQ(bed.problems(4, 256), "");
}

TEST(Tracer, AMeshModelledFarFromItsOriginIsTheSameForAllAndRight) {
  Bed bed;
  const Vec3d off(1000, 500, 3000);
  bed.add(soup(100, 5, 1.0, 0.3).moved(off), at(-off));
  bed.add(sphere(6, 8).moved(off), glm::rotate(at({2, 0, 0}), 1.0, Vec3d(1, 2, 3)) * at(-off));
  EXPECT_EQ(bed.problems(5, 256), "");
}

TEST(Tracer, ThinTrianglesAreTheSameForAllAndRight) {
  for (const double width : {1e-2, 1e-3, 1e-5}) {
    Bed bed;
    bed.add(needles(60, 6, 1.0, width));
    EXPECT_EQ(bed.problems(6, 192), "") << width;
  }
}

TEST(Tracer, TrianglesThatLoseTheirAreaAreNotHitWhateverTheTreesAge) {
  Bed bed;
  Random random(8);
  Geometry g = soup(60, 8, 1.0, 0.5);
  const std::uint32_t mesh = bed.add(g);
  ASSERT_EQ(bed.update(), "");
  const auto lattice = [&] {
    const double x = double(random.below(100)), y = double(random.below(100));
    return Vec3d(x, y, double(random.below(100))) / 256.0;
  };
  for (std::size_t i = 0; i < g.vertices.size(); i += 3) {
    const Vec3d from = lattice(), step = lattice();
    g.vertices[i] = Vec3(from);
    g.vertices[i + 1] = Vec3(from + step);
    g.vertices[i + 2] = Vec3(from + 3.0 * step);
  }
  bed.deform(mesh, g);
  ASSERT_EQ(bed.update(), "");
  std::vector<Ray> rays;
  for (int i = 0; i < 1000; ++i) {
    const Vec3d from = 3.0 * random.way();
    const std::size_t k = 3 * random.below(60);
    const double s = random.uniform(0.0, 1.0);
    const Vec3d to = (1 - s) * Vec3d(g.vertices[k]) + s * Vec3d(g.vertices[k + 2]);
    rays.push_back({from, to - from});
  }
  EXPECT_EQ(bed.differences(rays), "");
  for (const Found& found : bed.hits(rays)) EXPECT_FALSE(found.hit());
}

TEST(Tracer, ATriangleCollapsedFarAwayDoesNotChangeTheBitsOfOthers) {
  Bed bed;
  Geometry g = sphere(8, 12);
  g += triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const std::uint32_t mesh = bed.add(g);
  ASSERT_EQ(bed.update(), "");
  for (std::size_t i = 1; i <= 3; ++i) g.vertices[g.vertices.size() - i] = Vec3(1000.0f);
  bed.deform(mesh, g);
  ASSERT_EQ(bed.update(), "");
  std::vector<Ray> rays;
  Random random(7);
  for (int i = 0; i < 256; ++i) {
    const Vec3d from = 300.0 * random.way();
    rays.push_back({from, 0.7 * random.in_box(1.0) - from});
  }
  EXPECT_EQ(bed.differences(rays), "");
}

TEST(Tracer, RaysOutOfAnyRangeAreMissesAndSpoilNothingBesideThem) {
  Bed bed;
  bed.add(sphere(8, 12));
  bed.add(box({-3, -3, -3}, {3, 3, 3}), at({0.5, 0, 0}));
  ASSERT_EQ(bed.update(), "");
  const Ray good{{0.1, 0.1, 9}, {0, 0, -1}};
  const double bad[] = {double(nan), double(inf), -double(inf), 1e39, -1e39, 1e300};
  for (const double x : bad)
    for (int where = 0; where < 6; ++where) {
      std::vector<Ray> rays(70, good);
      for (const std::size_t i : {std::size_t(0), std::size_t(5), std::size_t(69)})
        (where < 3 ? rays[i].origin : rays[i].direction)[where % 3] = x;
      ASSERT_EQ(bed.differences(rays), "") << x << " in " << where;
      const std::vector<Found> found = bed.hits(rays);
      EXPECT_FALSE(found[0].hit()) << x << " in " << where;
      EXPECT_TRUE(found[1].hit());
    }
}

TEST(Tracer, IntervalsThatAreNoneAreMissesAndSpoilNothingBesideThem) {
  Bed bed;
  bed.add(sphere(8, 12));
  ASSERT_EQ(bed.update(), "");
  const Ray good{{0.1, 0.1, 5}, {0, 0, -1}};
  const float none[][2] = {{nan, inf}, {0, nan}, {nan, nan}, {5, 4}, {inf, 0}, {inf, -inf}};
  for (const auto& [near, far] : none) {
    std::vector<Ray> rays(70, good);
    for (const std::size_t i : {std::size_t(0), std::size_t(9)}) {
      rays[i].t_near = near;
      rays[i].t_far = far;
    }
    ASSERT_EQ(bed.differences(rays), "") << near << ' ' << far;
    EXPECT_FALSE(bed.hits(rays)[0].hit()) << near << ' ' << far;
    EXPECT_TRUE(bed.hits(rays)[1].hit());
  }
}

TEST(Tracer, AnIntervalMayLieBehindTheOrigin) {
  Bed bed;
  bed.add(sphere(8, 12));
  bed.add(sphere(8, 12), at({0, 0, 500}));
  ASSERT_EQ(bed.update(), "");
  Random random(9);
  std::vector<Ray> rays;
  for (int i = 0; i < 200; ++i) {
    const Vec3d way = random.way();
    const Vec3d target = 0.5 * random.in_box(1.0) + Vec3d(0, 0, i % 2 == 0 ? 0 : 500);
    rays.push_back({target + random.uniform(0.0, 1000.0) * way, way, -inf, 0.0f});
  }
  EXPECT_EQ(bed.differences(rays), "");
  EXPECT_EQ(bed.complaints(rays), "");
  std::size_t hits = 0;
  for (const Found& found : bed.hits(rays)) hits += found.hit();
  EXPECT_GT(hits, 150u);
}

TEST(Tracer, TheLibrarysOwnBruteForceIsThatOfTheTests) {
  Bed bed;
  Random random(10);
  const std::uint32_t mesh = add_mesh(bed.scene, soup(40, 10, 1.0, 0.4));
  for (int i = 0; i < 4; ++i) add_instance(bed.scene, mesh, anyhow(random, 1.0));
  accel::Accelerator accelerator;
  accelerator.update(bed.scene, bed.scene.changes(), {}, 4, pool(1));
  const std::vector<Ray> rays = nasty_rays(SceneOracle(bed.scene), 10, 64);
  const std::vector<Found> wanted = brute_force(bed.scene, accelerator.view(), rays);
  trace::RayPacket packet;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      packet.origin[k][i] = rays[i].origin[k];
      packet.direction[k][i] = rays[i].direction[k];
    }
    packet.t_near[i] = rays[i].t_near;
    packet.t_far[i] = rays[i].t_far;
  }
  packet.count = 64;
  packet.active = ~std::uint64_t(0);
  trace::HitPacket hits;
  trace::TraceCounters counters;
  trace::Tracer(accelerator.view(), simd::Isa::scalar).brute_force(packet, hits, counters);
  for (std::size_t i = 0; i < rays.size(); ++i)
    EXPECT_EQ((Found{hits.t[i], hits.instance_id[i], hits.prim_id[i], hits.u[i], hits.v[i]}),
              wanted[i]);
}

TEST(Tracer, CostIsNodesAndTrianglesOfTheRay) {
  Bed bed;
  bed.add(sphere(8, 12));
  accel::Accelerator accelerator;
  accelerator.update(bed.scene, bed.scene.changes(), {}, 4, pool(1));
  const trace::Tracer tracer(accelerator.view(), simd::Isa::scalar);
  trace::RayPacket packet{};
  for (int i = 0; i < 2; ++i) {
    packet.origin[2][i] = i == 0 ? 5.0 : -5.0;
    packet.direction[2][i] = -1.0;
    packet.t_far[i] = inf;
  }
  packet.count = 2;
  packet.active = 3;
  trace::HitPacket hits;
  trace::TraceCounters counters;
  std::uint32_t cost[trace::packet_capacity] = {};
  tracer.closest_hit_single(packet, hits, counters, cost);
  EXPECT_GT(cost[0], 3u);
  EXPECT_EQ(cost[0] + cost[1], counters.nodes_visited + counters.triangle_tests);
  EXPECT_EQ(counters.rays, 2u);
}

TEST(Tracer, ANodeThatAPacketEntersOnceIsEnteredByEachOfItsRays) {
  Scene scene;
  for (double x : {-3.0, 0.0, 3.0}) add(scene, sphere(8, 12).moved({x, 0.0, 0.0}));
  const auto trace_equal_rays = [](const trace::Tracer& tracer, int count, double x) {
    trace::RayPacket packet{};
    for (int i = 0; i < count; ++i) {
      packet.origin[0][i] = x;
      packet.origin[2][i] = 5.0;
      packet.direction[2][i] = -1.0;
      packet.t_far[i] = inf;
    }
    packet.count = std::uint32_t(count);
    packet.active = ~std::uint64_t(0) >> (64 - count);
    trace::HitPacket hits;
    trace::TraceCounters counters;
    tracer.closest_hit(packet, hits, counters);
    return counters;
  };
  for (const test::Setup& setup : setups()) {
    accel::UpdateOptions options;
    options.layout = setup.layout;
    options.structure = setup.structure;
    accel::Accelerator accelerator;
    accelerator.update(scene, scene.changes(), options, 4, pool(1));
    const trace::Tracer tracer(accelerator.view(), simd::Isa::scalar);
    const trace::TraceCounters one = trace_equal_rays(tracer, 1, 0.2);
    const trace::TraceCounters few = trace_equal_rays(tracer, 16, 0.2);
    const trace::TraceCounters many = trace_equal_rays(tracer, 64, 0.2);
    EXPECT_GT(few.node_entries, 16u * 3u) << setup;
    EXPECT_EQ(many.node_entries, 4 * few.node_entries) << setup;
    EXPECT_EQ(many.rays_met, 64u) << setup;
    EXPECT_EQ(one.node_entries, one.nodes_visited) << setup;
    EXPECT_EQ(trace_equal_rays(tracer, 16, 9.0).node_entries, 0u) << setup;
    EXPECT_EQ(trace_equal_rays(tracer, 16, 9.0).rays_met, 0u) << setup;
    EXPECT_EQ(trace_equal_rays(tracer, 1, 9.0).rays_met, 0u) << setup;
  }
}

}  // namespace
}  // namespace regraft::test
