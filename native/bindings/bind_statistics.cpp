#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <functional>
#include <type_traits>

#include "args.h"
#include "bindings.h"
#include "statistics.h"

namespace regraft::bindings {

namespace {

using AnyDict = Arg<"dict[str, typing.Any]">;

/// Calls `visit(name, member, meaning)` for every field in the order of the statistics line.
/// `FrameStatistics` has all of them, `UpdateStatistics` those of an update.
template <typename S, typename Visit>
void each_field(const Visit& visit) {
  constexpr bool frame = std::is_base_of_v<render::FrameStatistics, S>;
  if constexpr (frame) {
    visit("frame", &S::frame, "number of the frame");
    visit("evaluate_ms", &S::evaluate_ms, "the host's own evaluation, milliseconds");
    visit("extract_ms", &S::extract_ms, "reading the host's scene, milliseconds");
  }
  visit("update_ms", &S::update_ms, "bringing the trees up to date, milliseconds");
  if constexpr (frame) {
    visit("trace_ms", &S::trace_ms, "tracing, milliseconds");
    visit("shade_ms", &S::shade_ms, "shading, milliseconds");
    visit("write_ms", &S::write_ms, "writing the picture, milliseconds");
    visit("total_ms", &S::total_ms, "sum of all of the above");
  }
  visit("policy", &S::policy, "update policy in force");
  visit("structure", &S::structure, "kind of tree in force");
  visit("layout", &S::layout, "two-level or flat");
  visit("triangles", &S::triangles, "triangles rays can meet, once an instance");
  visit("instances", &S::instances, "instances rays can meet");
  visit("moved_instances", &S::moved_instances, "instances with a new matrix");
  visit("deformed_meshes", &S::deformed_meshes, "meshes with new positions");
  visit("deformed_triangles", &S::deformed_triangles, "their triangles");
  visit("nodes", &S::nodes, "nodes of all trees");
  visit("nodes_refitted", &S::nodes_refitted, "nodes whose box was recomputed");
  visit("nodes_rebuilt", &S::nodes_rebuilt, "nodes built anew");
  visit("pairs_considered", &S::pairs_considered, "pairs looked at by selective restructuring");
  visit("pairs_restructured", &S::pairs_restructured, "pairs restructured");
  visit("late_updates", &S::late_updates, "trees brought up to date when rays came near");
  visit("late_update_ms", &S::late_update_ms, "what the threads of those rays took for it");
  if constexpr (frame) {
    visit("rays_primary", &S::rays_primary, "rays from the camera");
    visit("rays_shadow", &S::rays_shadow, "rays to lights, and for occlusion");
    visit("rays_secondary", &S::rays_secondary, "reflected rays");
    visit("nodes_visited", &S::nodes_visited, "inner nodes entered");
    visit("triangle_tests", &S::triangle_tests, "ray and triangle pairs tested");
  }
  visit("culling_efficiency", &S::culling_efficiency, "expected tests of a ray that hits the root");
  if constexpr (frame) visit("observed_cost", &S::observed_cost, "tests a ray, as counted");
  visit("cost_ratio", &S::cost_ratio, "expected tests over those right after the last build");
  visit("kdtree_nodes", &S::kdtree_nodes, "nodes of the k-d tree built so far");
  visit("kdtree_built_fraction", &S::kdtree_built_fraction, "share of the k-d tree built so far");
  visit("kdtree_unbuilt_nodes", &S::kdtree_unbuilt_nodes, "k-d nodes that no ray has entered");
  visit("kdtree_large_leaves", &S::kdtree_large_leaves, "k-d leaves of more than 1,024 triangles");
  visit("memory_bytes", &S::memory_bytes, "geometry and trees, bytes");
  visit("left_out", &S::left_out_list, "what was not needed and so not done, in sentences");
  visit("warnings", &S::warnings_list, "what the user should know, in sentences");
}

template <typename S>
AnyDict as_dict(const S& statistics) {
  py::dict dict;
  each_field<S>([&](const char* name, auto member, const char*) {
    const auto& value = std::invoke(member, statistics);
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, Sentences>) {
      dict[name] = py::list(value.attr("copy")());
    } else {
      dict[name] = value;
    }
  });
  return as<AnyDict>(dict);
}

template <typename S>
void bind_fields(py::class_<S>& type) {
  each_field<S>([&](const char* name, auto member, const char* meaning) {
    if constexpr (std::is_member_function_pointer_v<decltype(member)>) {
      type.def_property_readonly(name, member, meaning);
    } else {
      type.def_readwrite(name, member, meaning);
    }
  });
  type.def("as_dict", &as_dict<S>,
           "All of it as a dict of plain Python values, in the order of the statistics line.");
  type.def("__repr__", [](const py::object& self) {
    const auto name = py::type::handle_of(self).attr("__name__");
    return py::str("<regraft.{} {}>").format(name, self.attr("as_dict")());
  });
}

py::array_t<double> array(const std::vector<double>& values) {
  return py::array_t<double>(py::ssize_t(values.size()), values.data());
}

}  // namespace

void bind_statistics(py::module_& module) {
  py::class_<UpdateStatistics> update(module, "UpdateStatistics",
                                      "What an update did and what the trees are like after it.");
  bind_fields(update);
  // Beside the statistics line: for benchmarks.
  update
      .def_property_readonly(
          "predicted_benefits",
          [](const UpdateStatistics& s) { return array(s.predicted_benefits); },
          "of each pair tried: expected tests a frame that were to be saved, float64")
      .def_property_readonly(
          "realised_savings", [](const UpdateStatistics& s) { return array(s.realised_savings); },
          "of each pair tried: expected tests a frame that were saved, float64")
      .def_readonly("select_ms", &UpdateStatistics::select_ms,
                    "choosing pairs and restructuring them, milliseconds");
  py::class_<FrameStatistics> frame(
      module, "FrameStatistics",
      "What a frame cost. The host adds `frame`, `evaluate_ms`, `extract_ms` and `write_ms`.");
  bind_fields(frame);
}

}  // namespace regraft::bindings
