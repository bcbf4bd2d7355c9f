// Times the eight ways to build a k-d tree and prints them as JSON, one object a line:
// `regraft bench kdtree` makes the tables. Processor time of one thread throughout.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "kdtree_file.h"
#include "kdtree_rays.h"
#include "kdtree_scenes.h"
#include "regraft/accel/accelerator.h"
#include "regraft/kdtree/statistics.h"
#include "regraft/trace/kernels.h"
#include "regraft/trace/tracer.h"

namespace {

using namespace regraft;
using bench::now;
using kdtree::OriginMetric;

constexpr int image = 512;

struct Picture {
  trace::TraceCounters counters;
  std::size_t visible = 0;  ///< different triangles seen
  double seconds = 0.0;
};

enum class Rays { in_packets, one_by_one };

Picture trace_picture(const trace::TraceView& view, const bench::View& camera, Rays how) {
  const trace::Tracer tracer(view, simd::best_isa());
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  Picture picture;
  trace::RayPacket rays;
  trace::HitPacket hits;
  rays.count = trace::packet_capacity;
  rays.active = ~std::uint64_t(0);
  for (int y0 = 0; y0 < image; y0 += 8)
    for (int x0 = 0; x0 < image; x0 += 8) {
      for (int i = 0; i < 64; ++i) {
        // Blocks of 4×4 in registers, as pictures have it.
        const int block = i / 8;
        const Vec3d direction =
            camera.direction(x0 + block % 2 * 4 + i % 4, y0 + block / 2 * 2 + i % 8 / 4, image);
        for (int k = 0; k < 3; ++k) {
          rays.origin[k][i] = camera.eye[k];
          rays.direction[k][i] = direction[k];
        }
        rays.t_near[i] = 0.0f;
        rays.t_far[i] = std::numeric_limits<float>::infinity();
      }
      const double start = now();
      if (how == Rays::in_packets)
        tracer.closest_hit(rays, hits, picture.counters);
      else
        tracer.closest_hit_single(rays, hits, picture.counters);
      picture.seconds += now() - start;
      for (int i = 0; i < 64; ++i)
        if (hits.prim_id[i] != invalid_id) seen.emplace(hits.instance_id[i], hits.prim_id[i]);
    }
  picture.visible = seen.size();
  return picture;
}

/// What one way of building costs for one picture.
struct Measured {
  double build = 0.0;
  Picture picture;            ///< of rays one by one
  double in_packets_s = 1e9;  ///< tracing it in packets
  kdtree::Statistics tree;
};

/// A scene whose meshes no tree has looked into yet: what a tree needs of them it makes.
struct Fresh {
  Executor executor{1};
  accel::Accelerator accelerator;
  trace::TraceView view;

  explicit Fresh(bench::KdtreeScene& scene) {
    accel::UpdateOptions options;
    options.structure = accel::Structure::kdtree;
    accelerator.update(scene.scene, scene.scene.changes(), options,
                       trace::kernels(simd::best_isa()).width, executor);
    view = accelerator.view();
  }
};

/// Builds in `tree` what is built in `model`.
void build_alike(const kdtree::KdTree& tree, kdtree::Node& node, const kdtree::Node& model) {
  if (!kdtree::Node::is_built(model.state)) return;
  tree.expand(node);
  if (!kdtree::Node::is_inner(node.state)) return;
  for (int side = 0; side < 2; ++side) build_alike(tree, node.children[side], model.children[side]);
}

/// The nodes that a picture needs are found by tracing it, then timed as they are built once more
/// without tracing: beside the tracing, their time would be lost in its noise.
Measured measure(bench::KdtreeScene& scene, const bench::View& view, const kdtree::Config& config) {
  Fresh traced(scene);
  const kdtree::KdTree tree(traced.view.kdtree->view(), config, traced.executor);
  traced.view.kdtree = &tree;
  trace_picture(traced.view, view, Rays::in_packets);
  Measured result;
  result.picture = trace_picture(traced.view, view, Rays::one_by_one);
  for (int again = 0; again < 3; ++again) {
    const double packets = trace_picture(traced.view, view, Rays::in_packets).seconds;
    const double singly = trace_picture(traced.view, view, Rays::one_by_one).seconds;
    result.in_packets_s = std::min(result.in_packets_s, packets);
    result.picture.seconds = std::min(result.picture.seconds, singly);
  }
  result.tree = kdtree::measure(tree);
  Fresh built(scene);
  const double start = now();
  const kdtree::KdTree same(built.view.kdtree->view(), config, built.executor);
  build_alike(same, same.root(), tree.root());
  result.build = now() - start;
  return result;
}

/// JSON has no word for what is not a number.
std::string number(double x) {
  return std::isfinite(x) ? std::to_string(x) : "null";
}

void print(const char* kind, const bench::KdtreeScene& scene, const bench::View& view,
           const kdtree::Config& config, const Measured& m) {
  const double primitives = double(scene.triangles);
  std::printf(
      R"({"kind":"%s","scene":"%s","view":"%s","triangles":%zu,"visible":%zu,)"
      R"("configuration":"%s","build_s":%.5f,"trace_s":%.5f,"trace_singly_s":%.5f,"nodes":%llu,)"
      R"("unbuilt":%llu,"references":%llu,"large_leaves":%llu,"built_fraction":%.5f,)"
      R"("sam_cost":%.3f,"quality":%s,"nodes_visited":%llu,"triangle_tests":%llu})"
      "\n",
      kind, scene.name, view.name, scene.triangles, m.picture.visible,
      std::string(kdtree::name(config)).c_str(), m.build, m.in_packets_s, m.picture.seconds,
      static_cast<unsigned long long>(m.tree.nodes()),
      static_cast<unsigned long long>(m.tree.unbuilt),
      static_cast<unsigned long long>(m.tree.references),
      static_cast<unsigned long long>(m.tree.large_leaves), m.tree.built_fraction, m.tree.sam_cost,
      number(m.tree.quality(primitives, config.cost)).c_str(),
      static_cast<unsigned long long>(m.picture.counters.nodes_visited),
      static_cast<unsigned long long>(m.picture.counters.triangle_tests));
  std::fflush(stdout);
}

void measure_and_print(const char* kind, bench::KdtreeScene& scene, const bench::View& view,
                       const kdtree::Config& config) {
  print(kind, scene, view, config, measure(scene, view, config));
}

/// Hunt, Mark, Fussell 2007, Table 1: all eight, near and far.
void table(bench::KdtreeScene scene) {
  for (const bench::View& view : scene.views)
    for (int way = 0; way < 8; ++way) {
      kdtree::Config config;
      config.lazy = (way & 1) != 0;
      config.scan = (way & 2) != 0;
      config.hierarchy = (way & 4) != 0;
      measure_and_print("table", scene, view, config);
    }
}

/// Build time against the scene's size, all built; against hidden geometry and against what is
/// seen, built lazily.
void growth(std::size_t triangles) {
  kdtree::Config eager;
  eager.lazy = false;
  for (std::size_t n = triangles / 16; n <= triangles; n *= 2) {
    bench::KdtreeScene scene = bench::courtyard(n);
    measure_and_print("growth_eager", scene, scene.views[0], eager);
  }
  for (int copies = 1; copies <= 16; copies *= 2) {
    bench::KdtreeScene scene = bench::courtyard(triangles / 4, copies);
    measure_and_print("growth_hidden", scene, scene.views[0], {});
  }
  bench::KdtreeScene scene = bench::courtyard(triangles);
  const bench::View near = scene.views[0];
  for (double away = 0.0; away < 1.01; away += 0.2) {
    bench::View view = near;
    view.eye = near.target + (near.eye - near.target) * (1.0 + 6.0 * away);
    measure_and_print("growth_visible", scene, view, {});
  }
}

constexpr std::pair<const char*, OriginMetric> metrics[] = {{"sah", OriginMetric::sah},
                                                            {"regions6", OriginMetric::regions6},
                                                            {"regions26", OriginMetric::regions26},
                                                            {"faces", OriginMetric::faces},
                                                            {"exact", OriginMetric::exact}};

/// Trees by every metric, and what rays of every kind cost in them.
void origin_table(bench::KdtreeScene scene, const Vec3d& inside, const Vec3d& outside) {
  Fresh fresh(scene);
  const HierarchyView& hierarchy = fresh.view.kdtree->view();
  const bench::View camera = scene.views[1];
  const std::vector<bench::RaySet> sets = bench::room_rays(
      scene.scene, fresh.view, bench::primary_rays(camera, image / 2), inside, outside);
  const Aabb room = fresh.view.kdtree->bounds();
  for (const auto& [name, metric] : metrics) {
    kdtree::Config config;
    config.lazy = false;
    config.origins = {metric, room};
    const double start = now();
    const kdtree::KdTree tree(hierarchy, config, fresh.executor);
    const double build = now() - start;
    trace::TraceView view = fresh.view;
    view.kdtree = &tree;
    for (const bench::RaySet& set : sets) {
      const auto nothing = [](std::size_t, double, std::uint32_t, std::uint32_t) {};
      bench::RayWork work = bench::trace_rays(view, set, nothing);
      for (int again = 0; again < 2; ++again)
        work.seconds = std::min(work.seconds, bench::trace_rays(view, set, nothing).seconds);
      std::printf(R"({"kind":"origins","scene":"%s","metric":"%s","rays":"%s","count":%zu,)"
                  R"("build_s":%.5f,"trace_s":%.5f,"nodes_visited":%llu,"triangle_tests":%llu})"
                  "\n",
                  scene.name, name, set.name, set.rays.size(), build, work.seconds,
                  static_cast<unsigned long long>(work.counters.nodes_visited),
                  static_cast<unsigned long long>(work.counters.triangle_tests));
      std::fflush(stdout);
    }
  }
}

}  // namespace

/// Arguments, if any: triangles of the largest scene, or a scene's name and its file.
int main(int argc, char** argv) {
  if (argc == 3) {
    table(bench::read_scene(argv[1], argv[2]));
    return 0;
  }
  const std::size_t triangles = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 541000;
  if (triangles < 20000) {
    std::fprintf(stderr,
                 "usage: regraft_bench_kdtree [triangles, at least 20000 | NAME SCENE_FILE]\n");
    return 2;
  }
  table(bench::courtyard(triangles));
  table(bench::conference(triangles * 495 / 541));
  growth(triangles);
  origin_table(bench::conference(triangles / 16), {0, 0, 4.5}, {10, 20, 60});
  origin_table(bench::courtyard(triangles / 16), {0, 0, 8}, {100, 20, 200});
  return 0;
}
