// Times the first picture of a scene nobody has built anything for: build and 512² primary rays,
// processor time of one thread, as JSON, one contender a line. Every object is a mesh of its own.

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "kdtree_scenes.h"
#include "peer_embree.h"
#include "regraft/accel/accelerator.h"
#include "regraft/trace/kernels.h"

namespace {

using namespace regraft;

constexpr int image = 512;

double now() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

/// Every instance's triangles in the world, as meshes of their own, and all in one.
struct Flattened {
  Scene scene;
  bench::Triangles all;
  std::vector<bench::View> views;

  explicit Flattened(const bench::KdtreeScene& from) : views(from.views) {
    for (const Instance& placed : from.scene.instances()) {
      const Mesh& mesh = from.scene.meshes()[placed.mesh];
      bench::Triangles flat;
      for (const Vec3& v : mesh.vertices)
        flat.vertices.emplace_back(Vec3d(placed.object_to_world * glm::dvec4(Vec3d(v), 1.0)));
      flat.triangles = mesh.triangles;
      const auto base = std::uint32_t(all.vertices.size());
      all.vertices.insert(all.vertices.end(), flat.vertices.begin(), flat.vertices.end());
      for (const Triangle& t : flat.triangles) all.triangles.push_back(t + Triangle(base));
      Instance instance;
      instance.mesh = scene.add_mesh({flat.vertices, flat.triangles, {}, {}}, "object");
      scene.add_instance(instance);
    }
  }
};

bench::RaySet rays_of(const bench::View& view) {
  bench::RaySet set{"primary", false, true, {}, {}, {}};
  for (int tile = 0; tile < image / 8 * (image / 8); ++tile)
    for (int i = 0; i < 64; ++i) {
      const int block = i / 8;
      const int x = tile % (image / 8) * 8 + block % 2 * 4 + i % 4;
      const int y = tile / (image / 8) * 8 + block / 2 * 2 + i % 8 / 4;
      set.add(view.eye, view.direction(x, y, image), bench::no_limit);
    }
  return set;
}

void print(const char* contender, const bench::View& view, std::size_t triangles, double build,
           double trace, std::size_t hits) {
  std::printf(R"({"kind":"first","contender":"%s","view":"%s","triangles":%zu,"build_s":%.4f,)"
              R"("trace_s":%.4f,"hits":%zu})"
              "\n",
              contender, view.name, triangles, build, trace, hits);
  std::fflush(stdout);
}

void ours(const char* name, accel::Structure structure, Flattened& flat, const bench::View& view) {
  const bench::RaySet set = rays_of(view);
  Executor one(1);
  accel::Accelerator accelerator;
  accel::UpdateOptions options;
  options.structure = structure;
  const double start = now();
  accelerator.update(flat.scene, flat.scene.changes(), options,
                     trace::kernels(simd::best_isa()).width, one);
  const double built = now();
  const trace::Tracer tracer(accelerator.view(), simd::best_isa());
  trace::TraceCounters counters;
  std::size_t hits = 0;
  for (std::size_t p = 0; p < set.size() / 64; ++p) {
    trace::RayPacket rays;
    trace::HitPacket found;
    bench::fill(set, p, rays);
    tracer.closest_hit(rays, found, counters);
    for (int i = 0; i < 64; ++i) hits += found.prim_id[i] != invalid_id;
  }
  print(name, view, flat.all.triangles.size(), built - start, now() - built, hits);
}

#ifdef REGRAFT_WITH_EMBREE
void embree(const char* name, RTCBuildQuality quality, const Flattened& flat,
            const bench::View& view) {
  const bench::RaySet set = rays_of(view);
  bench::Triangles copy = flat.all;
  const double start = now();
  const bench::EmbreeScene peer(std::move(copy), {.quality = quality});
  const double built = now();
  const std::size_t hits = bench::embree_packets<8>(peer.scene(), set, set.coherent, 0, set.size());
  print(name, view, flat.all.triangles.size(), built - start, now() - built, hits);
}
#endif

}  // namespace

/// The argument, if any: triangles.
int main(int argc, char** argv) {
  const std::size_t triangles = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10'000'000;
  if (triangles < 20000) {
    std::fprintf(stderr, "usage: regraft_bench_first [triangles, at least 20000]\n");
    return 2;
  }
  Flattened flat(bench::courtyard(triangles));
  for (const bench::View& view : flat.views) {
    ours("kdtree", accel::Structure::kdtree, flat, view);
    ours("bvh", accel::Structure::bvh, flat, view);
#ifdef REGRAFT_WITH_EMBREE
    embree("embree low", RTC_BUILD_QUALITY_LOW, flat, view);
    embree("embree medium", RTC_BUILD_QUALITY_MEDIUM, flat, view);
#endif
  }
  return 0;
}
