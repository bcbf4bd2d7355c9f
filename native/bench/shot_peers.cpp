// A shot, ours and Embree's in one run: every frame each contender brings its trees up to date and
// shoots the same primary and shadow rays, in turns. Prints a line of JSON a frame and contender.
// Usage: regraft_bench_peers SHOT SIZE THREADS REPEATS POLICY,… LAYOUT,…

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <sstream>
#include <string>

#include "peer_shot.h"
#include "regraft/accel/accelerator.h"
#include "regraft/core/executor.h"
#include "regraft/trace/kernels.h"
#include "shot_file.h"

namespace {

using namespace regraft;
using bench::RaySet;

/// Rays are handed to threads in pieces of so many.
constexpr std::size_t piece = 64 * 32;
/// Where the sun's light goes, as in `study/aging.py`.
const Vec3d sunlight(0.3, 0.5, -0.8);

struct Options {
  std::string shot;
  int size = 512;
  unsigned threads = 1;
  int repeats = 1;
  std::vector<std::string> policies, layouts;
};

/// What every contender is told of a frame.
struct Frame {
  const Scene& scene;
  ChangeSet changes;
  std::uint32_t left;
};

/// One way to keep a scene and to trace it. `packets`: as many rays at once as it takes at best,
/// else one by one.
class Contender {
 public:
  virtual ~Contender() = default;
  virtual void update(const Frame& frame) = 0;
  /// @return how many of the rays [begin, end) hit.
  virtual std::size_t shoot(const RaySet& set, bool packets, std::size_t begin,
                            std::size_t end) = 0;
  virtual void end_frame() {}
  /// With the vertices and triangles.
  virtual std::size_t bytes(const Scene& scene) const = 0;
};

class Ours final : public Contender {
 public:
  Ours(accel::Policy policy, accel::Layout layout, Executor& executor) : executor_(executor) {
    options_.policy = policy;
    options_.layout = layout;
    options_.structure = accel::Structure::bvh;
  }
  void update(const Frame& frame) override {
    options_.frames_left = frame.left;
    const int width = trace::kernels(isa_).width;
    bytes_ =
        accelerator_.update(frame.scene, frame.changes, options_, width, executor_).memory_bytes;
  }
  std::size_t shoot(const RaySet& set, bool packets, std::size_t begin, std::size_t end) override {
    const trace::Tracer tracer = this->tracer();
    trace::TraceCounters counters;
    const std::size_t sum = bench::shoot(tracer, packets, set, begin, end, counters);
    if (packets) note(counters);
    return sum;
  }
  /// As a renderer does: policies decide by what rays met.
  void end_frame() override {
    accelerator_.note_rays(rays_.exchange(0), nodes_.exchange(0), tests_.exchange(0));
  }
  std::size_t bytes(const Scene&) const override { return bytes_; }
  trace::Tracer tracer() const { return {accelerator_.view(), isa_}; }
  std::pair<Vec3d, Vec3d> bounds() const { return accelerator_.world_bounds(); }

 private:
  void note(const trace::TraceCounters& counters) {
    rays_ += counters.rays;
    nodes_ += counters.nodes_visited;
    tests_ += counters.triangle_tests;
  }

  Executor& executor_;
  simd::Isa isa_ = simd::best_isa();
  accel::UpdateOptions options_;
  accel::Accelerator accelerator_;
  std::size_t bytes_ = 0;
  std::atomic<std::uint64_t> rays_{0}, nodes_{0}, tests_{0};
};

#ifdef REGRAFT_WITH_EMBREE
class Embree final : public Contender {
 public:
  Embree(bench::EmbreeWay way, RTCBuildQuality quality, unsigned threads,
         const bench::PeerGeometry& geometry)
      : shot_(way, quality, threads),
        geometry_(geometry),
        is_instanced_(way == bench::EmbreeWay::instances) {}
  void update(const Frame& frame) override { shot_.update(geometry_, frame.scene); }
  std::size_t shoot(const RaySet& set, bool packets, std::size_t begin, std::size_t end) override {
    // Embree 3.13.5 does not return from coherent occlusion rays through instances.
    const bool coherent = set.coherent && !(set.any && is_instanced_);
    return packets ? bench::embree_packets<16>(shot_.scene(), set, coherent, begin, end)
                   : bench::embree_single(shot_.scene(), set, coherent, begin, end);
  }
  std::size_t bytes(const Scene&) const override {
    if (!is_instanced_)
      return shot_.bytes() + geometry_.vertices().size_bytes() + geometry_.triangles().size_bytes();
    std::size_t sum = shot_.bytes();
    for (const bench::Triangles& mesh : geometry_.meshes())
      sum += mesh.vertices.size() * sizeof(Vec3) + mesh.triangles.size() * sizeof(Triangle);
    return sum;
  }

 private:
  bench::EmbreeShot shot_;
  const bench::PeerGeometry& geometry_;
  bool is_instanced_;
};
#endif

struct Entry {
  std::string name;
  std::unique_ptr<Contender> contender;
};

template <typename T, std::size_t N>
T named(const std::string& text, const std::array<T, N>& values) {
  for (const T value : values)
    if (accel::name(value) == text) return value;
  std::exit((std::fprintf(stderr, "%s is not known\n", text.c_str()), 2));
}

std::vector<Entry> ours(const Options& options, Executor& executor) {
  using accel::Layout;
  using accel::Policy;
  constexpr std::array policies{
      Policy::automatic, Policy::refit,     Policy::rebuild,         Policy::lm,
      Policy::rtdeform,  Policy::selective, Policy::selective_rotate};
  constexpr std::array layouts{Layout::two_level, Layout::flat};
  std::vector<Entry> entries;
  for (const std::string& layout : options.layouts)
    for (const std::string& policy : options.policies)
      entries.push_back(
          {"regraft " + policy + " " + layout,
           std::make_unique<Ours>(named(policy, policies), named(layout, layouts), executor)});
  return entries;
}

#ifdef REGRAFT_WITH_EMBREE
void add_embree(unsigned threads, const bench::PeerGeometry& geometry,
                std::vector<Entry>& entries) {
  using bench::EmbreeWay;
  for (const auto& [way, name] : {std::pair{EmbreeWay::one_mesh, "one mesh"},
                                  {EmbreeWay::geometries, "geometries"},
                                  {EmbreeWay::instances, "instances"}})
    for (const auto& [quality, how] : {std::pair{RTC_BUILD_QUALITY_REFIT, "refit"},
                                       {RTC_BUILD_QUALITY_LOW, "morton"},
                                       {RTC_BUILD_QUALITY_MEDIUM, "sah"}})
      entries.push_back({std::string("embree ") + how + " " + name,
                         std::make_unique<Embree>(way, quality, threads, geometry)});
}
#endif

/// Elapsed and processor time of all threads, milliseconds.
struct Time {
  double wall = 0.0, cpu = 0.0;
};
Time now() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return {
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
          .count(),
      double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6};
}
template <typename Work>
Time timed(const Work& work) {
  const Time start = now();
  work();
  const Time end = now();
  return {end.wall - start.wall, end.cpu - start.cpu};
}

std::size_t shoot(Contender& contender, const RaySet& set, bool packets, Executor& executor) {
  std::atomic<std::size_t> hits{0};
  executor.parallel_for(
      (set.size() + piece - 1) / piece, 1, [&](std::size_t begin, std::size_t end) {
        hits += contender.shoot(set, packets, begin * piece, std::min(set.size(), end * piece));
      });
  return hits;
}

/// Rays towards the sun from wherever `primary` hits, set off by 10⁻⁵ of the scene.
RaySet shadow_rays(const RaySet& primary, const Ours& reference, const Scene& scene) {
  RaySet set{"shadow", true, true, {}, {}, {}};
  const trace::Tracer tracer = reference.tracer();
  const auto [low, high] = reference.bounds();
  const double diagonal = glm::length(high - low), off = 1e-5 * diagonal;
  const auto far = float(2.0 * diagonal);  // leads out of the scene from anywhere in it
  trace::RayPacket rays;
  trace::HitPacket hits;
  trace::TraceCounters counters;
  for (std::size_t p = 0; p < primary.size() / 64; ++p) {
    bench::fill(primary, p, rays);
    tracer.closest_hit(rays, hits, counters);
    for (int i = 0; i < 64; ++i) {
      if (hits.prim_id[i] == invalid_id) continue;
      const Instance& instance = scene.instances()[hits.instance_id[i]];
      const Mesh& mesh = scene.meshes()[instance.mesh];
      const Triangle& t = mesh.triangles[hits.prim_id[i]];
      const auto corner = [&](std::uint32_t v) {
        return Vec3d(instance.object_to_world * glm::dvec4(Vec3d(mesh.vertices[v]), 1.0));
      };
      const Vec3d a = corner(t.x), o(rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]);
      const Vec3d d(rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
      Vec3d normal = glm::normalize(glm::cross(corner(t.y) - a, corner(t.z) - a));
      if (glm::dot(normal, d) > 0.0) normal = -normal;
      set.add(o + double(hits.t[i]) * d + off * normal, -sunlight, far);
    }
  }
  while (set.size() % 64 != 0) set.add(high + diagonal, -sunlight, far);
  return set;
}

void measure(Entry& entry, const Frame& frame, const RaySet& primary, const RaySet& shadow,
             Executor& executor, const std::string& head) {
  Contender& c = *entry.contender;
  std::ostringstream line;
  const auto put = [&](const char* name, const Time& time) {
    line << ", \"" << name << "_ms\": " << time.wall << ", \"" << name << "_cpu_ms\": " << time.cpu;
  };
  put("update", timed([&] { c.update(frame); }));
  for (const bool packets : {true, false}) {
    std::size_t hits = 0, shadowed = 0;
    put(packets ? "primary" : "primary_single",
        timed([&] { hits = shoot(c, primary, packets, executor); }));
    put(packets ? "shadow" : "shadow_single",
        timed([&] { shadowed = shoot(c, shadow, packets, executor); }));
    if (packets) line << ", \"hits\": " << hits << ", \"shadowed\": " << shadowed;
  }
  c.end_frame();
  std::printf("%s, \"contender\": \"%s\", \"bytes\": %zu%s}\n", head.c_str(), entry.name.c_str(),
              c.bytes(frame.scene), line.str().c_str());
  std::fflush(stdout);
}

/// The whole shot once. Who goes first changes from frame to frame.
void replay(const Options& options, int repeat, Executor& executor) {
  bench::ShotFile file(options.shot.c_str());
  Scene scene;
  Ours reference(accel::Policy::automatic, accel::Layout::two_level, executor);
  std::vector<Entry> entries = ours(options, executor);
#ifdef REGRAFT_WITH_EMBREE
  bench::PeerGeometry geometry;
  add_embree(options.threads, geometry, entries);
#endif
  for (std::uint32_t position = 0; position < file.frames(); ++position) {
    const std::uint32_t number = file.advance(scene);
    const Frame frame{scene, scene.take_changes(), file.frames() - position};
#ifdef REGRAFT_WITH_EMBREE
    geometry.follow(scene, frame.changes);
#endif
    reference.update(frame);
    const RaySet primary = file.primary_rays(options.size);
    const RaySet shadow = shadow_rays(primary, reference, scene);
    shoot(reference, primary, true, executor);
    reference.end_frame();
    const std::string head = "{\"repeat\": " + std::to_string(repeat) +
                             ", \"frame\": " + std::to_string(number) +
                             ", \"rays\": " + std::to_string(primary.size() + shadow.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
      measure(entries[(i + position) % entries.size()], frame, primary, shadow, executor, head);
  }
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: %s SHOT SIZE THREADS REPEATS POLICY,... LAYOUT,...\n", argv[0]);
    return 2;
  }
  const Options options{argv[1],
                        std::max(8, std::atoi(argv[2]) / 8 * 8),
                        unsigned(std::max(1, std::atoi(argv[3]))),
                        std::max(1, std::atoi(argv[4])),
                        split(argv[5]),
                        split(argv[6])};
  Executor executor(options.threads);
  try {
    for (int repeat = 0; repeat < options.repeats; ++repeat) replay(options, repeat, executor);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
