// Rays lost on a closed mesh: a sphere of 1.3 million triangles, rays from inside at its vertices,
// at the middles of its edges and in random directions; in place, far away, tiny and huge.
// Usage: regraft_bench_leaks [rays of each kind, default 10,000,000]. Fails if one of ours is lost.

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <glm/gtc/matrix_transform.hpp>

#include "bench_rays.h"
#include "peer_embree.h"
#include "regraft/accel/accelerator.h"
#include "regraft/core/executor.h"
#include "regraft/trace/kernels.h"

namespace {

using namespace regraft;
using bench::Triangles;

enum class Aim { vertices, edges, anywhere };
constexpr const char* names[] = {"vertices", "edge midpoints", "random"};

/// Where ray i aims and where it starts, in object space: the same for every placement.
struct Shot {
  Vec3d from, to;
};
Shot shot(const Triangles& mesh, Aim aim, std::size_t i) {
  std::mt19937_64 random(i);
  const auto uniform = [&] { return double(random() >> 11) * 0x1p-52 - 1.0; };
  Shot s;
  s.from = 0.5 * Vec3d(uniform(), uniform(), uniform());
  const Triangle& t = mesh.triangles[random() % mesh.triangles.size()];
  const Vec3d a(mesh.vertices[t.x]), b(mesh.vertices[t.y]);
  s.to = aim == Aim::vertices ? a
         : aim == Aim::edges  ? 0.5 * (a + b)
                              : Vec3d(uniform(), uniform(), uniform());
  if (aim == Aim::anywhere) s.to = s.from + s.to;
  return s;
}

/// Calls `lost(rays, count)` with packets of 64 and sums what it returns.
template <typename Lost>
std::size_t count_lost(const Triangles& mesh, const Mat4d& place, Aim aim, std::size_t count,
                       Executor& executor, const Lost& lost) {
  std::atomic<std::size_t> sum{0};
  executor.parallel_for(count / 64, 256, [&](std::size_t begin, std::size_t end) {
    trace::RayPacket rays;
    rays.count = 64;
    rays.active = ~std::uint64_t(0);
    for (std::size_t p = begin; p < end; ++p) {
      for (std::size_t i = 0; i < 64; ++i) {
        const Shot s = shot(mesh, aim, 64 * p + i);
        const Vec3d from(place * glm::dvec4(s.from, 1.0)), to(place * glm::dvec4(s.to, 1.0));
        for (int k = 0; k < 3; ++k) {
          rays.origin[k][i] = from[k];
          rays.direction[k][i] = to[k] - from[k];
        }
        rays.t_near[i] = 0.0f;
        rays.t_far[i] = bench::no_limit;
      }
      sum += lost(rays);
    }
  });
  return sum;
}

std::size_t lost_by_us(const trace::Tracer& tracer, const trace::RayPacket& rays) {
  trace::HitPacket together, apart;
  trace::TraceCounters counters;
  tracer.closest_hit(rays, together, counters);
  tracer.closest_hit_single(rays, apart, counters);
  std::size_t lost = 0;
  for (int i = 0; i < 64; ++i)
    lost += together.prim_id[i] == invalid_id || apart.prim_id[i] == invalid_id;
  return lost;
}

#ifdef REGRAFT_WITH_EMBREE
std::size_t lost_by_embree(RTCScene scene, const trace::RayPacket& rays) {
  bench::RaySet set;
  for (int i = 0; i < 64; ++i)
    set.add({rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
            {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]}, rays.t_far[i]);
  return 64 - bench::embree_single(scene, set, set.coherent, 0, 64);
}
#endif

}  // namespace

int main(int argc, char** argv) {
  const std::size_t count = argc > 1 ? std::size_t(std::atoll(argv[1])) : 10'000'000;
  const Triangles mesh = bench::sphere(1'300'000);
  Executor executor;
  Scene scene;
  Instance instance;
  instance.mesh = scene.add_mesh({mesh.vertices, mesh.triangles, {}, {}}, "sphere");
  const std::uint32_t id = scene.add_instance(instance);
  const Mat4d one(1.0);
  const std::pair<const char*, Mat4d> places[] = {
      {"in place", one},
      {"translated by 1e5", glm::translate(one, Vec3d(1e5, -1e5, 1e5))},
      {"scaled by 1e-4", glm::scale(one, Vec3d(1e-4))},
      {"scaled by 1e6", glm::scale(one, Vec3d(1e6))}};
  std::size_t all = 0;
  for (const auto& [place_name, place] : places) {
    scene.set_transform(id, place);
    accel::Accelerator accelerator;
    accelerator.update(scene, scene.changes(), {}, trace::kernels(simd::best_isa()).width,
                       executor);
    const trace::Tracer tracer(accelerator.view(), simd::best_isa());
    for (const Aim aim : {Aim::vertices, Aim::edges, Aim::anywhere}) {
      const std::size_t lost =
          count_lost(mesh, place, aim, count, executor,
                     [&](const trace::RayPacket& rays) { return lost_by_us(tracer, rays); });
      all += lost;
      std::printf("regraft %-18s %-15s %zu of %zu lost\n", place_name, names[int(aim)], lost,
                  count);
      std::fflush(stdout);
    }
  }
#ifdef REGRAFT_WITH_EMBREE
  for (const bool robust : {true, false}) {
    bench::EmbreeOptions options;
    options.robust = robust;
    const bench::EmbreeScene peer(mesh, options);
    for (const Aim aim : {Aim::vertices, Aim::edges, Aim::anywhere})
      std::printf("embree %-6s in place     %-15s %zu of %zu lost\n", robust ? "robust" : "fast",
                  names[int(aim)],
                  count_lost(mesh, one, aim, count, executor,
                             [&](const trace::RayPacket& rays) {
                               return lost_by_embree(peer.scene(), rays);
                             }),
                  count);
  }
#endif
  return all == 0 ? 0 : 1;
}
