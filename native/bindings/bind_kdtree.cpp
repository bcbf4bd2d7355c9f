#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "bindings.h"
#include "hit_batch.h"
#include "regraft/kdtree/split_errors.h"
#include "regraft/kdtree/statistics.h"

namespace regraft::bindings {

namespace {

using kdtree::OriginMetric;
using NumberDict = Arg<"dict[str, float]">;
using NumberDicts = Arg<"list[dict[str, float]]">;
using FloatArg = Arg<"float">;
using SettingsArg = Arg<"collections.abc.Sequence[tuple[float, int]]">;
using BoxArg = Arg<"numpy.typing.ArrayLike | None">;
using Choice = Arg<"tuple[str, numpy.typing.NDArray[numpy.float64]]">;

constexpr std::array<std::pair<const char*, OriginMetric>, 5> metrics{
    {{"sah", OriginMetric::sah},
     {"regions6", OriginMetric::regions6},
     {"regions26", OriginMetric::regions26},
     {"faces", OriginMetric::faces},
     {"exact", OriginMetric::exact}}};

kdtree::ScanConfig read_scan(const py::object& epsilon, const py::object& samples) {
  kdtree::ScanConfig scan;
  scan.epsilon = checked_number(epsilon, "epsilon");
  scan.samples = int(checked_int(samples, "samples", 1, 63));
  if (!(scan.epsilon >= 0.0)) throw py::value_error("epsilon: below 0");
  if (!std::has_single_bit(unsigned(scan.samples) + 1))
    throw py::value_error("samples: not one less than a power of two");
  return scan;
}

/// A k-d tree of its own over what a scene shows, as docs/api.md describes it. The scene cannot
/// change for as long as it lives.
class StudyTree {
 public:
  StudyTree(SceneHandle& scene, const kdtree::Config& config)
      : scene_(scene), tracing_(scene), view_(scene.renderer.accelerator().view()) {
    if (view_.kdtree == nullptr)
      throw py::value_error("scene: it is empty, or was not updated with structure \"kdtree\"");
    const py::gil_scoped_release no_gil;
    tree_.emplace(view_.kdtree->view(), placed(config), scene.renderer.executor());
    view_.kdtree = &*tree_;
  }

  HitBatch closest_hit(const RealsArg& origins, const RealsArg& directions, const LimitArg& t_near,
                       const LimitArg& t_far) {
    const RayArrays rays = ray_arrays(origins, directions, t_near, t_far);
    HitBatch hits(rays.origins.shape(0));
    const HitArrays arrays = hits.arrays();
    trace(rays.batch, [&](const trace::Tracer& tracer, std::size_t begin, std::size_t end) {
      return trace_closest(rays.batch, tracer, scene_.renderer.scene(), Search::trees, begin, end,
                           arrays);
    });
    return hits;
  }

  BoolArray any_hit(const RealsArg& origins, const RealsArg& directions, const LimitArg& t_near,
                    const LimitArg& t_far) {
    const RayArrays rays = ray_arrays(origins, directions, t_near, t_far);
    py::array_t<bool> hit(rays.origins.shape(0));
    bool* out = hit.mutable_data();
    trace(rays.batch, [&](const trace::Tracer& tracer, std::size_t begin, std::size_t end) {
      return trace_any(rays.batch, tracer, begin, end, out);
    });
    return as<BoolArray>(hit);
  }

  NumberDict statistics() const {
    const kdtree::Statistics s = kdtree::measure(*tree_);
    return as<NumberDict>(
        py::dict(py::arg("nodes") = s.nodes(), py::arg("leaves") = s.leaves,
                 py::arg("depth") = s.depth, py::arg("references") = s.references,
                 py::arg("bytes") = s.bytes, py::arg("sam_cost") = s.sam_cost,
                 py::arg("quality") = s.quality(tree_->builder().weight(), tree_->config().cost),
                 py::arg("built_fraction") = s.built_fraction,
                 py::arg("nodes_visited") = nodes_visited_.load(),
                 py::arg("triangle_tests") = triangle_tests_.load()));
  }

  NumberDicts split_errors(const SettingsArg& settings) const {
    std::vector<kdtree::ScanConfig> scans;
    for (const auto& [epsilon, samples] :
         py::cast<std::vector<std::pair<py::object, py::object>>>(settings))
      scans.push_back(read_scan(epsilon, samples));
    std::vector<kdtree::SplitErrors> errors;
    {
      const py::gil_scoped_release no_gil;
      errors = kdtree::split_errors(tree_->view(), tree_->config(), scans);
    }
    py::list rows;
    for (const kdtree::SplitErrors& e : errors) {
      rows.append(py::dict(py::arg("nodes_compared") = e.nodes,
                           py::arg("worst_excess") = e.worst_excess,
                           py::arg("mean_excess") = e.mean_excess,
                           py::arg("worst_certificate") = e.worst_certificate,
                           py::arg("mean_certificate") = e.mean_certificate,
                           py::arg("mean_samples") = e.mean_samples));
    }
    return as<NumberDicts>(rows);
  }

  /// By which metric to split for rays that start like those of `pilot`, and their box.
  Choice choose_metric(const RealsArg& pilot, const FloatsArg& camera) const {
    const py::array array = real_array(pilot, "pilot", -1);
    const Rows from = rows(array);
    const auto eye = checked_numbers<3>(camera, "camera");
    std::vector<Vec3> starts;
    for (py::ssize_t i = 0; i < array.shape(0); ++i)
      starts.push_back(tree_place(from.at(std::size_t(i))));
    const kdtree::OriginChoice choice =
        kdtree::choose_origin_metric(starts, tree_->bounds(), tree_place({eye[0], eye[1], eye[2]}));
    py::array_t<double> box({2, 3});
    for (int k = 0; k < 3; ++k) {
      box.mutable_at(0, k) = double(choice.origins.lo[k]) + view_.scene_origin[k];
      box.mutable_at(1, k) = double(choice.origins.hi[k]) + view_.scene_origin[k];
    }
    const auto* name = std::find_if(metrics.begin(), metrics.end(),
                                    [&](const auto& m) { return m.second == choice.metric; });
    return as<Choice>(py::make_tuple(name->first, box));
  }

 private:
  Vec3 tree_place(const Vec3d& world) const {
    Vec3 place;
    for (int k = 0; k < 3; ++k) place[k] = float(world[k] - view_.scene_origin[k]);
    return place;
  }

  /// With the box of origins in the coordinates of the tree.
  kdtree::Config placed(kdtree::Config config) const {
    Aabb& box = config.origins.origins;
    if (!box.empty()) box = {tree_place(Vec3d(box.lo)), tree_place(Vec3d(box.hi))};
    return config;
  }

  template <typename Work>
  void trace(const RayBatch& batch, const Work& work) {
    const trace::Tracer tracer(view_, scene_.renderer.isa());
    for_blocks(scene_.renderer.executor(), batch.packet_count(), Sharing{},
               [&](std::size_t begin, std::size_t end) {
                 const trace::TraceCounters done = work(tracer, begin, end);
                 nodes_visited_ += done.nodes_visited;
                 triangle_tests_ += done.triangle_tests;
               });
  }

  SceneHandle& scene_;
  Tracing tracing_;
  trace::TraceView view_;
  std::optional<kdtree::KdTree> tree_;
  std::atomic<std::uint64_t> nodes_visited_{0};
  std::atomic<std::uint64_t> triangle_tests_{0};
};

/// Sets the three switches from a name such as "lazy+scan".
void read_build(const std::string& build, kdtree::Config& config) {
  for (unsigned way = 0; way < 8; ++way) {
    config.lazy = (way & 1) != 0;
    config.scan = (way & 2) != 0;
    config.hierarchy = (way & 4) != 0;
    if (kdtree::name(config) == build) return;
  }
  throw py::value_error("build: \"" + build +
                        "\" is neither eager nor made of lazy, scan, hierarchy joined by +");
}

OriginMetric read_metric(const std::string& metric) {
  for (const auto& [name, value] : metrics)
    if (metric == name) return value;
  throw py::value_error("metric: \"" + metric +
                        "\" is none of sah, regions6, regions26, faces, exact");
}

Aabb read_box(const py::object& object) {
  const auto array = py::array_t<double>::ensure(object);
  if (!array || array.ndim() != 2 || array.shape(0) != 2 || array.shape(1) != 3)
    throw py::value_error("origins: not two corners of three numbers");
  Aabb box;
  for (py::ssize_t corner = 0; corner < 2; ++corner)
    box.extend(Vec3(Vec3d(array.at(corner, 0), array.at(corner, 1), array.at(corner, 2))));
  return box;
}

std::unique_ptr<StudyTree> make_tree(SceneHandle& scene, const std::string& build,
                                     const FloatArg& epsilon, const IntArg& samples,
                                     const std::string& metric, const BoxArg& origins) {
  kdtree::Config config;
  read_build(build, config);
  config.precision = read_scan(epsilon, samples);
  config.origins.metric = read_metric(metric);
  if (!origins.is_none()) config.origins.origins = read_box(origins);
  return std::make_unique<StudyTree>(scene, config);
}

}  // namespace

void bind_kdtree(py::module_& module) {
  const auto no_limit = py::float_(std::numeric_limits<double>::infinity());
  py::class_<StudyTree>(module, "KdTree", R"(A k-d tree of its own over what a scene shows.

For studies: it is built as the caller says, and counts what rays take in it. As long as it
lives, the scene cannot change.)")
      .def(py::init(&make_tree), py::keep_alive<1, 2>(), py::arg("scene"),
           py::arg("build") = "lazy+scan+hierarchy", py::kw_only(), py::arg("epsilon") = 0.3,
           py::arg("samples") = 15, py::arg("metric") = "sah", py::arg("origins") = py::none(),
           R"(scene: updated with structure "kdtree". build: "eager", or of lazy, scan and hierarchy
those that are on, joined by +.

epsilon, samples: of the scan; see `split_errors`. metric: sah, regions6, regions26, faces
or exact; all but the first suppose rays that start in the box `origins` (2, 3).

Raises ValueError for what is none of these, RuntimeError if the scene changed since its
last update.)")
      .def("closest_hit", &StudyTree::closest_hit, py::arg("origins"), py::arg("directions"),
           py::arg("t_near") = 0.0, py::arg("t_far") = no_limit,
           "As `Scene.closest_hit`, and the same bits.")
      .def("any_hit", &StudyTree::any_hit, py::arg("origins"), py::arg("directions"),
           py::arg("t_near") = 0.0, py::arg("t_far") = no_limit, "As `Scene.any_hit`.")
      .def("statistics", &StudyTree::statistics,
           R"(What is built of the tree, and what all its rays have taken so far: a dict of

`nodes`, `leaves`, `depth`, `references`, `bytes`, `sam_cost`, `quality` (smaller is better;
NaN below two triangles), `built_fraction`, `nodes_visited`, `triangle_tests`.)")
      .def("choose_metric", &StudyTree::choose_metric, py::arg("pilot"), py::arg("camera"),
           R"(The metric by which to split for rays that start where those of a sample start.

pilot: (N, 3), origins of the sample's rays; of a ray to a light, the light. camera: where
the eye is. Returns "sah", or "regions6" where most of them lie inside the scene, and the
box (2, 3) in which nearly all do.)")
      .def("split_errors", &StudyTree::split_errors, py::arg("settings"),
           R"(How far splits of scans are from the best, over the nodes of the exact tree.

settings: of each scan epsilon, the error it may leave, and the number of planes of each
of its two passes if that is infinite: one less than a power of two, at most 63. Returns
for each a dict of `nodes_compared`, `worst_excess`, `mean_excess` (cost over the least
possible cost, less 1), `worst_certificate`, `mean_certificate` (what the scan proves),
`mean_samples` (planes tried). Nodes of so few entries that scans sort them do not count.)");
}

}  // namespace regraft::bindings
