// What trees take to build, to refit and to bring into the layout of rays, beside Embree and beside
// what memory allows, all in turns:
//   regraft_bench_build [--triangles N] [--rounds N] [--threads N]
// The best time of all rounds counts, as other work on the machine only ever adds to it; the time
// of all threads' processors beside that of the clock shows how busy it was.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <numeric>
#include <string_view>

#include "bench_scenes.h"
#include "peer_build.h"
#include "regraft/accel/triangle_bounds.h"
#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/living_bvh.h"
#include "regraft/bvh/morton_builder.h"
#include "regraft/bvh/wide_bvh.h"

namespace {

using namespace regraft;
using bench::Triangles;

struct Options {
  std::size_t triangles = 1000000;
  int rounds = 10;
  unsigned threads = 2;
};

/// One thing that is timed. `prepare` is not.
struct Contender {
  const char* name;
  std::function<void()> run;
  std::function<void()> prepare = [] {};
  double bytes = 0.0;  ///< that it has to read and write; 0: not counted
  double wall_ms = 1e30;
  double processor_ms = 1e30;
};

double processor_ms() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
}

void race(std::vector<Contender>& contenders, int rounds) {
  for (int round = 0; round < rounds; ++round)
    for (Contender& contender : contenders) {
      contender.prepare();
      const auto start = std::chrono::steady_clock::now();
      const double processor = processor_ms();
      contender.run();
      const std::chrono::duration<double, std::milli> wall =
          std::chrono::steady_clock::now() - start;
      contender.processor_ms = std::min(contender.processor_ms, processor_ms() - processor);
      contender.wall_ms = std::min(contender.wall_ms, wall.count());
    }
}

void print(const char* scene, std::size_t triangles, const std::vector<Contender>& contenders) {
  for (const Contender& c : contenders) {
    std::printf("%-7s %-24s %8.2f ms %8.2f ms of processors %7.1f M triangles/s", scene, c.name,
                c.wall_ms, c.processor_ms, double(triangles) / c.wall_ms / 1e3);
    if (c.bytes > 0.0) std::printf(" %6.1f GB/s", c.bytes / c.wall_ms / 1e6);
    std::printf("\n");
  }
  std::fflush(stdout);
}

/// A mesh in two poses and what builders know of the first.
struct Input {
  Mesh mesh;
  std::vector<Vec3> poses[2];
  AlignedVector<Aabb> boxes;
  std::vector<std::uint32_t> ids;
  int pose = 0;

  Input(int kind, std::size_t count) {
    const Triangles first = bench::make(kind, std::int64_t(count), 0.0f);
    poses[0] = first.vertices;
    poses[1] = bench::make(kind, std::int64_t(count), 0.01f).vertices;
    mesh.vertices = first.vertices;
    mesh.triangles = first.triangles;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      boxes.push_back(accel::fast_triangle_bounds(mesh, t).aabb());
    ids.resize(boxes.size());
    std::iota(ids.begin(), ids.end(), 0u);
  }
  void move() { mesh.vertices = poses[++pose % 2]; }
};

/// The speed of memory itself, by what a copy reads and writes.
struct Copy {
  AlignedVector<float> from, to;
  Executor& executor;

  Copy(std::size_t bytes, Executor& pool)
      : from(bytes / 8, 1.0f), to(bytes / 8, 2.0f), executor(pool) {}
  void run() {
    executor.parallel_for(from.size(), 65536, [&](std::size_t begin, std::size_t end) {
      std::copy(from.begin() + std::ptrdiff_t(begin), from.begin() + std::ptrdiff_t(end),
                to.begin() + std::ptrdiff_t(begin));
    });
  }
};

/// What a refit has to read, and to write where it also reads it.
double refit_bytes(const Input& input, const bvh::LivingBvh& tree) {
  return double(input.mesh.triangles.size() * sizeof(Triangle)) +
         double(input.mesh.vertices.size() * sizeof(Vec3)) +
         double(tree.bvh.prim_ids.size() * sizeof(std::uint32_t)) +
         2.0 * double(tree.bvh.nodes.size() * sizeof(bvh::Node)) +
         2.0 * double(tree.inner.size() * sizeof(bvh::InnerMetrics));
}

/// Trees of ours, each kept until the next of its kind is built, as it is from frame to frame.
struct Ours {
  Input& input;
  Executor& executor;
  bvh::Bvh morton, sah;
  bvh::LivingBvh living;
  bvh::WideBvh wide;

  Ours(Input& in, Executor& pool) : input(in), executor(pool) {
    living.bvh = bvh::BinnedSahBuilder::build(input.boxes, input.ids, {}, executor);
    living.start_measuring(executor);
    wide = bvh::WideBvh::derive(living.bvh, 8, executor);
  }
  void refit() {
    bvh::refit(
        living, [&](std::uint32_t t) { return accel::fast_triangle_bounds(input.mesh, t); },
        executor);
  }
  void refit_alone() {
    bvh::refit(
        living.bvh, [&](std::uint32_t t) { return accel::fast_triangle_bounds(input.mesh, t); },
        executor);
  }

  std::vector<Contender> contenders() {
    const double tree_bytes = refit_bytes(input, living);
    const double metrics_bytes = 2.0 * double(living.inner.size() * sizeof(bvh::InnerMetrics));
    const double wide_bytes = double(wide.node_count() * sizeof(bvh::WideNode<8>)) +
                              double(living.bvh.nodes.size() * sizeof(bvh::Node));
    const auto move = [this] { input.move(); };
    return {
        {"Morton",
         [this] { morton = bvh::MortonBuilder::build(input.boxes, input.ids, {}, executor); }},
        {"binned SAH",
         [this] { sah = bvh::BinnedSahBuilder::build(input.boxes, input.ids, {}, executor); }},
        {"refit with metrics", [this] { refit(); }, move, tree_bytes},
        {"refit without", [this] { refit_alone(); }, move, tree_bytes - metrics_bytes},
        {"wide layout, refitted", [this] { wide.refit(living.bvh, executor); }, move, wide_bytes},
        {"wide layout, derived", [this] { wide = bvh::WideBvh::derive(living.bvh, 8, executor); }}};
  }
};

void race_scene(const char* scene, int kind, const Options& options) {
  Executor executor(options.threads);
  Input input(kind, options.triangles);
  Ours ours(input, executor);
  std::vector<Contender> contenders = ours.contenders();
  Copy copy(contenders[2].bytes / 2.0, executor);
  contenders.push_back({"copy of memory", [&] { copy.run(); }, [] {}, contenders[2].bytes});
#ifdef REGRAFT_WITH_EMBREE
  bench::PeerBuild low(input.boxes, RTC_BUILD_QUALITY_LOW, options.threads);
  bench::PeerBuild medium(input.boxes, RTC_BUILD_QUALITY_MEDIUM, options.threads);
  contenders.push_back({"Embree Morton", [&] { low.run(); }, [&] { low.prepare(); }});
  contenders.push_back({"Embree SAH", [&] { medium.run(); }, [&] { medium.prepare(); }});
  std::vector<std::unique_ptr<bench::EmbreeScene>> scenes;
  const auto commit = [&](const char* name, RTCBuildQuality quality, bool dynamic) {
    const bench::EmbreeOptions how{quality, true, dynamic, options.threads};
    scenes.push_back(
        std::make_unique<bench::EmbreeScene>(Triangles{input.poses[0], input.mesh.triangles}, how));
    bench::EmbreeScene& peer = *scenes.back();
    contenders.push_back({name, [&peer] { peer.update(); },
                          [&peer, &input] {
                            input.move();
                            std::copy(input.mesh.vertices.begin(), input.mesh.vertices.end(),
                                      peer.vertices().begin());
                          }});
  };
  commit("Embree scene, low", RTC_BUILD_QUALITY_LOW, true);
  commit("Embree scene, medium", RTC_BUILD_QUALITY_MEDIUM, false);
  commit("Embree scene, refit", RTC_BUILD_QUALITY_REFIT, true);
#endif
  race(contenders, options.rounds);
  print(scene, input.ids.size(), contenders);
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    const int value = std::max(1, std::atoi(argv[i + 1]));
    if (name == "--triangles")
      options.triangles = std::size_t(value);
    else if (name == "--rounds")
      options.rounds = value;
    else if (name == "--threads")
      options.threads = unsigned(value);
    else
      std::exit((std::fprintf(stderr, "unknown option %s\n", argv[i]), 2));
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = parse(argc, argv);
  race_scene("sheet", 0, options);
  race_scene("chunks", 1, options);
  return 0;
}
