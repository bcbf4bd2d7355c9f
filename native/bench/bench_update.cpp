#include <benchmark/benchmark.h>

#include "bench_scenes.h"
#include "peer_embree.h"
#include "regraft/accel/accelerator.h"
#include "regraft/trace/kernels.h"

namespace {

using namespace regraft;
using bench::Triangles;

/// One mesh, updated by one policy each frame: arguments are the kind of mesh, its triangles and
/// the number of threads.
void update(benchmark::State& state, accel::Policy policy) {
  const Triangles poses[2] = {bench::make(state.range(0), state.range(1), 0.0f),
                              bench::make(state.range(0), state.range(1), 0.05f)};
  Executor executor(unsigned(state.range(2)));
  Scene scene;
  Instance instance;
  instance.mesh = scene.add_mesh({poses[0].vertices, poses[0].triangles, {}, {}}, "mesh");
  scene.add_instance(instance);
  accel::Accelerator accelerator;
  accel::UpdateOptions options;
  options.policy = policy;
  const int width = trace::kernels(simd::best_isa()).width;
  auto statistics = accelerator.update(scene, scene.take_changes(), options, width, executor);
  std::size_t frame = 0;
  for (auto _ : state) {
    state.PauseTiming();
    scene.set_vertices(instance.mesh, poses[++frame % 2].vertices);
    const ChangeSet changes = scene.take_changes();
    state.ResumeTiming();
    statistics = accelerator.update(scene, changes, options, width, executor);
  }
  const auto triangles = double(poses[0].triangles.size());
  state.counters["triangles/s"] =
      benchmark::Counter(triangles, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/triangle"] = double(statistics.memory_bytes) / triangles;
}
void refit(benchmark::State& state) {
  update(state, accel::Policy::refit);
}
void rebuild(benchmark::State& state) {
  update(state, accel::Policy::rebuild);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"kind", "triangles", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int kind : {0, 1})
    for (const int triangles : {250000, 1000000})
      for (const int threads : {1, 2}) b->Args({kind, triangles, threads});
}
BENCHMARK(refit)->Apply(sizes);
BENCHMARK(rebuild)->Apply(sizes);

#ifdef REGRAFT_WITH_EMBREE
void embree_update(benchmark::State& state, RTCBuildQuality quality, bool dynamic) {
  const Triangles poses[2] = {bench::make(state.range(0), state.range(1), 0.0f),
                              bench::make(state.range(0), state.range(1), 0.05f)};
  bench::EmbreeScene peer(poses[0], {quality, true, dynamic, unsigned(state.range(2))});
  std::size_t frame = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const std::vector<Vec3>& next = poses[++frame % 2].vertices;
    std::copy(next.begin(), next.end(), peer.vertices().begin());
    state.ResumeTiming();
    peer.update();
  }
  state.counters["triangles/s"] = benchmark::Counter(double(poses[0].triangles.size()),
                                                     benchmark::Counter::kIsIterationInvariantRate);
}
void embree_refit(benchmark::State& state) {
  embree_update(state, RTC_BUILD_QUALITY_REFIT, true);
}
void embree_sah(benchmark::State& state) {
  embree_update(state, RTC_BUILD_QUALITY_MEDIUM, false);
}
void embree_two_level_sah(benchmark::State& state) {
  embree_update(state, RTC_BUILD_QUALITY_MEDIUM, true);
}
void embree_morton(benchmark::State& state) {
  embree_update(state, RTC_BUILD_QUALITY_LOW, true);
}
BENCHMARK(embree_refit)->Apply(sizes);
BENCHMARK(embree_sah)->Apply(sizes);
BENCHMARK(embree_two_level_sah)->Apply(sizes);
BENCHMARK(embree_morton)->Apply(sizes);
#endif

}  // namespace
