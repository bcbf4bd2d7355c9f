// Rays against static scenes, ours and Embree's in one run: the same rays, one mesh each, all
// contenders taking turns. Prints a table and, with --json FILE, writes every median.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <memory>
#include <string_view>

#include "bench_rays.h"
#include "peer_embree.h"
#include "regraft/accel/accelerator.h"
#include "regraft/core/executor.h"
#include "regraft/trace/kernels.h"

namespace {

using namespace regraft;
using bench::RaySet;
using bench::Triangles;

/// Rays are handed to threads in pieces of so many; the unit of every contender is 64.
constexpr std::size_t piece = 64 * 32;

struct Options {
  int image = 1024;
  int rounds = 7;
  unsigned threads = 1;
  std::string json;
  std::string only;
};

/// One way to shoot rays [begin, end) of a set; @return how many hit.
struct Contender {
  std::string name;
  std::function<std::size_t(const RaySet&, std::size_t begin, std::size_t end)> shoot;
};

struct Line {
  std::string scene, rays, contender;
  std::size_t triangles, count, hits;
  double ms;
};

/// Our accelerator over one mesh.
struct Ours {
  Scene scene;
  accel::Accelerator accelerator;
  Ours(const Triangles& mesh, simd::Isa isa, Executor& executor) {
    Instance instance;
    instance.mesh = scene.add_mesh({mesh.vertices, mesh.triangles, {}, {}}, "mesh");
    scene.add_instance(instance);
    accel::UpdateOptions options;
    options.policy = accel::Policy::rebuild;
    accelerator.update(scene, scene.take_changes(), options, trace::kernels(isa).width, executor);
  }
};

#ifdef REGRAFT_WITH_EMBREE
void add_embree(const Triangles& mesh, unsigned threads, std::vector<Contender>& contenders) {
  for (const bool robust : {true, false})
    for (const bool dynamic : {false, true}) {
      bench::EmbreeOptions options;
      options.robust = robust;
      options.dynamic = dynamic;
      options.threads = threads;
      const auto peer = std::make_shared<bench::EmbreeScene>(mesh, options);
      const std::string name = std::string(robust ? "embree robust" : "embree fast") +
                               (dynamic ? " dynamic" : " static");
      contenders.push_back({name + " 8", [peer](const RaySet& set, std::size_t b, std::size_t e) {
                              return bench::embree_packets<8>(peer->scene(), set, set.coherent, b,
                                                              e);
                            }});
      contenders.push_back({name + " 16", [peer](const RaySet& set, std::size_t b, std::size_t e) {
                              return bench::embree_packets<16>(peer->scene(), set, set.coherent, b,
                                                               e);
                            }});
      contenders.push_back({name + " 1", [peer](const RaySet& set, std::size_t b, std::size_t e) {
                              return bench::embree_single(peer->scene(), set, set.coherent, b, e);
                            }});
    }
}
#endif

double clock_ms(bool processor) {
  if (!processor)
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

/// Medians over rounds in which all contenders take turns: of processor time with one thread, of
/// elapsed time with several.
void race(const std::string& scene, std::size_t triangles, const RaySet& set,
          std::span<const Contender> contenders, const Options& options, Executor& executor,
          std::vector<Line>& lines) {
  std::vector<std::vector<double>> times(contenders.size());
  std::vector<std::size_t> hits(contenders.size());
  for (int round = 0; round < options.rounds; ++round)
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      std::vector<std::size_t> found((set.size() + piece - 1) / piece);
      const double start = clock_ms(options.threads == 1);
      executor.parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          found[i] = contenders[c].shoot(set, i * piece, std::min(set.size(), (i + 1) * piece));
      });
      times[c].push_back(clock_ms(options.threads == 1) - start);
      hits[c] = 0;
      for (const std::size_t n : found) hits[c] += n;
    }
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    std::sort(times[c].begin(), times[c].end());
    lines.push_back({scene, set.name, contenders[c].name, triangles, set.size(), hits[c],
                     times[c][times[c].size() / 2]});
  }
}

double rate(const Line& line) {
  return double(line.count) / line.ms / 1e3;
}

/// Each way in millions of rays a second, and our best against Embree's best robust and best of
/// all.
void print(std::span<const Line> lines) {
  double ours = 0.0, robust = 0.0, best = 0.0;
  for (const Line& line : lines) {
    std::printf("%-12s %-18s %-24s %8.2f M/s  %9zu hits\n", line.scene.c_str(), line.rays.c_str(),
                line.contender.c_str(), rate(line), line.hits);
    const bool peer = line.contender.starts_with("embree");
    (peer ? best : ours) = std::max(peer ? best : ours, rate(line));
    if (line.contender.starts_with("embree robust")) robust = std::max(robust, rate(line));
  }
  if (best > 0.0)
    std::printf("%-12s %-18s regraft / best robust Embree %.2f, / best Embree %.2f\n",
                lines[0].scene.c_str(), lines[0].rays.c_str(), ours / robust, ours / best);
  std::fflush(stdout);
}

void write_json(const Options& options, std::span<const Line> lines) {
  std::ofstream out(options.json);
  out << "{\"image\": " << options.image << ", \"rounds\": " << options.rounds
      << ", \"threads\": " << options.threads << ", \"isa\": \"" << simd::name(simd::best_isa())
      << "\", \"lines\": [";
  for (std::size_t i = 0; i < lines.size(); ++i)
    out << (i == 0 ? "\n" : ",\n") << "{\"scene\": \"" << lines[i].scene
        << "\", \"triangles\": " << lines[i].triangles << ", \"rays\": \"" << lines[i].rays
        << "\", \"count\": " << lines[i].count << ", \"contender\": \"" << lines[i].contender
        << "\", \"median_ms\": " << lines[i].ms << ", \"hits\": " << lines[i].hits << "}";
  out << "\n]}\n";
}

void race_scene(const std::string& name, const Triangles& mesh, const Options& options,
                std::vector<Line>& lines) {
  Executor executor(options.threads);
  const simd::Isa isa = simd::best_isa();
  const Ours ours(mesh, isa, executor);
  const trace::Tracer tracer(ours.accelerator.view(), isa);
  std::vector<Contender> contenders;
  for (const bool packets : {true, false})
    contenders.push_back({packets ? "regraft packets" : "regraft single",
                          [&, packets](const RaySet& set, std::size_t begin, std::size_t end) {
                            trace::TraceCounters counters;
                            return bench::shoot(tracer, packets, set, begin, end, counters);
                          }});
#ifdef REGRAFT_WITH_EMBREE
  add_embree(mesh, options.threads, contenders);
#endif
  const RaySet primary = bench::primary_rays(options.image);
  const bench::SecondaryRays secondary = bench::secondary_rays(primary, mesh, tracer);
  RaySet closest = secondary.occlusion;
  closest.name = "occlusion closest";
  closest.any = false;
  const RaySet* const sets[] = {&primary, &secondary.shadow, &secondary.occlusion, &closest};
  for (const RaySet* set : sets) {
    const std::size_t before = lines.size();
    race(name, mesh.triangles.size(), *set, contenders, options, executor, lines);
    print(std::span(lines).subspan(before));
  }
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    const char* value = argv[i + 1];
    if (name == "--json")
      options.json = value;
    else if (name == "--scene")
      options.only = value;
    else if (name == "--image")
      options.image = std::max(8, std::atoi(value) / 8 * 8);
    else if (name == "--rounds")
      options.rounds = std::max(1, std::atoi(value));
    else if (name == "--threads")
      options.threads = unsigned(std::max(1, std::atoi(value)));
    else
      std::exit((std::fprintf(stderr, "unknown option %s\n", argv[i]), 2));
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = parse(argc, argv);
  const std::pair<const char*, std::function<Triangles()>> scenes[] = {
      {"sheet 250k", [] { return bench::sheet(250000, 0.5f); }},
      {"sheet 1M", [] { return bench::sheet(1000000, 0.5f); }},
      {"balls 250k", [] { return bench::balls(250000); }},
      {"balls 1M", [] { return bench::balls(1000000); }},
      {"chunks 250k", [] { return bench::chunks(250000, 0.5f); }},
      {"chunks 1M", [] { return bench::chunks(1000000, 0.5f); }}};
  std::vector<Line> lines;
  for (const auto& [name, make] : scenes)
    if (options.only.empty() || options.only == name) race_scene(name, make(), options, lines);
  if (!options.json.empty()) write_json(options, lines);
  return lines.empty() ? 1 : 0;
}
