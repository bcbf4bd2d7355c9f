#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "args.h"
#include "bindings.h"
#include "machine_costs.h"
#include "read_dataclass.h"
#include "statistics.h"

namespace regraft::bindings {

namespace {

using NumberDict = Arg<"dict[str, float]">;

/// The value that `names` pairs with `text`.
template <typename T, std::size_t N>
T choice(const std::string& text, const char* what,
         const std::array<std::pair<const char*, T>, N>& names) {
  std::string known;
  for (const auto& [name, value] : names) {
    if (text == name) return value;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw py::value_error(std::string(what) + ": \"" + text + "\" is none of " + known);
}

accel::UpdateOptions update_options(const std::string& policy, const std::string& structure,
                                    const std::string& layout,
                                    const std::optional<IntArg>& frames_left) {
  using accel::Layout;
  using accel::Policy;
  using accel::Structure;
  static constexpr std::array<std::pair<const char*, Policy>, 8> policies{
      {{"auto", Policy::automatic},
       {"refit", Policy::refit},
       {"rebuild", Policy::rebuild},
       {"lm", Policy::lm},
       {"rtdeform", Policy::rtdeform},
       {"selective", Policy::selective},
       {"selective+rotate", Policy::selective_rotate},
       {"shot", Policy::shot}}};
  static constexpr std::array<std::pair<const char*, Structure>, 3> structures{
      {{"auto", Structure::automatic}, {"bvh", Structure::bvh}, {"kdtree", Structure::kdtree}}};
  static constexpr std::array<std::pair<const char*, Layout>, 2> layouts{
      {{"two-level", Layout::two_level}, {"flat", Layout::flat}}};
  accel::UpdateOptions options;
  options.policy = choice(policy, "policy", policies);
  options.structure = choice(structure, "structure", structures);
  options.layout = choice(layout, "layout", layouts);
  const MachineCosts& costs = machine_costs();
  options.costs.rebuild = costs.rebuild;
  options.costs.refine = costs.refine;
  options.costs.morton = costs.morton;
  options.costs.leaf = costs.leaf;
  if (frames_left) {
    options.frames_left =
        static_cast<std::uint32_t>(checked_int(*frames_left, "frames_left", 1, 0x7FFFFFFF));
  }
  return options;
}

UpdateStatistics update(SceneHandle& self, const std::string& policy, const std::string& structure,
                        const std::string& layout, const std::optional<IntArg>& frames_left,
                        const std::optional<CameraArg>& camera) {
  accel::UpdateOptions options = update_options(policy, structure, layout, frames_left);
  if (camera) options.camera = read_camera(*camera);
  const Updating updating(self);
  accel::UpdateStatistics statistics;
  {
    const py::gil_scoped_release no_gil;
    statistics = self.renderer.update(options);
  }
  return UpdateStatistics(std::move(statistics));
}

NumberDict quality(SceneHandle& self, bool fresh) {
  const Tracing tracing(self);
  accel::Quality q;
  {
    const py::gil_scoped_release no_gil;
    q = self.renderer.accelerator().quality(self.renderer.scene(), fresh, self.renderer.executor());
  }
  py::dict numbers(py::arg("sah_cost") = q.sah_cost,
                   py::arg("culling_efficiency") = q.culling_efficiency, py::arg("epo") = q.epo,
                   py::arg("origin_cost") = q.origin_cost, py::arg("cost_ratio") = q.cost_ratio,
                   py::arg("depth") = q.depth, py::arg("bytes") = q.bytes);
  if (q.kdtree_q) numbers["kdtree_q"] = *q.kdtree_q;
  return as<NumberDict>(std::move(numbers));
}

py::array_t<double> bounds(SceneHandle& self) {
  const Tracing tracing(self);
  const auto [lo, hi] = self.renderer.accelerator().world_bounds();
  if (!(lo.x <= hi.x)) throw py::value_error("bounds: the scene has nothing that can be hit");
  py::array_t<double> box({2, 3});
  for (int k = 0; k < 3; ++k) {
    box.mutable_at(0, k) = lo[k];
    box.mutable_at(1, k) = hi[k];
  }
  return box;
}

}  // namespace

void bind_update(SceneClass& scene) {
  scene
      .def("update", &update, py::arg("policy") = "auto", py::arg("structure") = "auto",
           py::arg("layout") = "two-level", py::kw_only(), py::arg("frames_left") = py::none(),
           py::arg("camera") = py::none(),
           R"(Brings the trees up to date with the scene; free where nothing changed.

policy: auto, refit, rebuild, lm, rtdeform, selective, selective+rotate or shot; the last
plans for the key frames that `set_key_vertices` and `set_key_transforms` gave.
structure: auto, bvh or kdtree; layout: two-level or flat.
frames_left: how many frames the shot still has, if that is known. camera: from where the
scene is going to be looked at, if that is known. Both help `auto`. Releases the GIL.

Raises ValueError for an unknown name, or for "shot" if something moves whose key frames
nobody gave.)")
      .def("quality", &quality, py::arg("fresh") = false,
           R"(How good the trees are: a dict of

`sah_cost` and `culling_efficiency`, expected tests of a ray that hits the scene; `epo`,
the extra tests that overlap of nodes causes on surfaces; `origin_cost`, expected tests of
a ray that starts anywhere in the scene's box (0 of a k-d tree); `cost_ratio`, the cost
now over that of the last build, or of a full build made beside it if `fresh`; `depth`;
`bytes`; of a k-d tree also `kdtree_q`, lower is better, comparable between scenes of any
size (Hunt, Mark, Fussell 2007), not a number for a single triangle.

Raises RuntimeError if the scene changed since its last update.)")
      .def("bounds", &bounds,
           R"(World box of what can be hit: (2, 3) float64, lowest and highest corner.

Raises ValueError if there is nothing, RuntimeError if the scene changed since its last
update.)");
}

}  // namespace regraft::bindings
