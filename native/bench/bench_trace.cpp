#include <benchmark/benchmark.h>

#include <limits>

#include "peer_embree.h"
#include "regraft/accel/accelerator.h"
#include "regraft/trace/kernels.h"
#include "regraft/trace/tracer.h"

namespace {

using namespace regraft;
using bench::Triangles;

constexpr int image = 512;
constexpr float infinity = std::numeric_limits<float>::infinity();

void fill(trace::RayPacket& rays, int tile) {
  rays.count = trace::packet_capacity;
  rays.active = ~std::uint64_t(0);
  const int x0 = tile % (image / 8) * 8, y0 = tile / (image / 8) * 8;
  for (int i = 0; i < 64; ++i) {
    const Vec3d direction = bench::pixel_direction(x0 + i % 8, y0 + i / 8, image);
    for (int k = 0; k < 3; ++k) {
      rays.origin[k][i] = bench::eye()[k];
      rays.direction[k][i] = direction[k];
    }
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = infinity;
  }
}

/// A 512² image of primary rays; arguments: kind, triangles, threads, instruction set.
void primary(benchmark::State& state, bool packets) {
  const auto isa = simd::Isa(state.range(3));
  const auto isas = simd::available_isas();
  if (std::find(isas.begin(), isas.end(), isa) == isas.end()) {
    state.SkipWithError("this machine lacks the instruction set");
    return;
  }
  const Triangles mesh = bench::make(state.range(0), state.range(1), 0.5f);
  Executor executor(unsigned(state.range(2)));
  Scene scene;
  Instance instance;
  instance.mesh = scene.add_mesh({mesh.vertices, mesh.triangles, {}, {}}, "mesh");
  scene.add_instance(instance);
  accel::Accelerator accelerator;
  accelerator.update(scene, scene.take_changes(), {accel::Policy::rebuild},
                     trace::kernels(isa).width, executor);
  const trace::Tracer tracer(accelerator.view(), isa);
  constexpr int tiles = image / 8 * (image / 8);
  std::vector<trace::TraceCounters> counters(tiles);
  for (auto _ : state)
    executor.parallel_for(tiles, 16, [&](std::size_t begin, std::size_t end) {
      trace::RayPacket rays;
      trace::HitPacket hits;
      for (std::size_t tile = begin; tile < end; ++tile) {
        fill(rays, int(tile));
        counters[tile] = {};
        if (packets)
          tracer.closest_hit(rays, hits, counters[tile]);
        else
          tracer.closest_hit_single(rays, hits, counters[tile]);
      }
    });
  trace::TraceCounters sum;
  for (const trace::TraceCounters& c : counters) sum += c;
  state.SetLabel(std::string(simd::name(isa)));
  state.counters["rays/s"] =
      benchmark::Counter(double(sum.rays), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["tests/ray"] = double(sum.triangle_tests) / double(sum.rays);
}
void primary_packets(benchmark::State& state) {
  primary(state, true);
}
void primary_single(benchmark::State& state) {
  primary(state, false);
}

void cases(benchmark::internal::Benchmark* b) {
  b->ArgNames({"kind", "triangles", "threads", "isa"});
  b->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int kind : {0, 1})
    for (const int triangles : {250000, 1000000})
      for (const simd::Isa isa :
           {simd::Isa::scalar, simd::Isa::sse, simd::Isa::avx2, simd::Isa::avx512})
        b->Args({kind, triangles, 2, int(isa)});
}
BENCHMARK(primary_packets)->Apply(cases);
BENCHMARK(primary_single)->Apply(cases);

#ifdef REGRAFT_WITH_EMBREE
/// Embree on the same rays, in packets of 8.
void embree_primary_packets(benchmark::State& state) {
  const bench::EmbreeScene peer(bench::make(state.range(0), state.range(1), 0.5f),
                                RTC_BUILD_QUALITY_MEDIUM, 2);
  Executor executor(unsigned(state.range(2)));
  for (auto _ : state)
    executor.parallel_for(image / 2, 8, [&](std::size_t begin, std::size_t end) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      alignas(32) int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
      for (int y = int(begin) * 2; y < int(end) * 2; y += 2)
        for (int x = 0; x < image; x += 4) {
          RTCRayHit8 rays = {};
          for (int i = 0; i < 8; ++i) {
            const Vec3d d = bench::pixel_direction(x + i % 4, y + i / 4, image);
            rays.ray.org_x[i] = float(bench::eye().x);
            rays.ray.org_y[i] = float(bench::eye().y);
            rays.ray.org_z[i] = float(bench::eye().z);
            rays.ray.dir_x[i] = float(d.x);
            rays.ray.dir_y[i] = float(d.y);
            rays.ray.dir_z[i] = float(d.z);
            rays.ray.tfar[i] = infinity;
            rays.ray.mask[i] = ~0u;
            rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
          }
          rtcIntersect8(valid, peer.scene(), &context, &rays);
          benchmark::DoNotOptimize(rays.ray.tfar);
        }
    });
  state.counters["rays/s"] =
      benchmark::Counter(double(image) * image, benchmark::Counter::kIsIterationInvariantRate);
}
void peer_cases(benchmark::internal::Benchmark* b) {
  b->ArgNames({"kind", "triangles", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int kind : {0, 1})
    for (const int triangles : {250000, 1000000}) b->Args({kind, triangles, 2});
}
BENCHMARK(embree_primary_packets)->Apply(peer_cases);
#endif

}  // namespace
