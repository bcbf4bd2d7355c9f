#include <pybind11/stl.h>

#include <algorithm>
#include <thread>

#include "args.h"
#include "bindings.h"
#include "regraft/simd/dispatch.h"

namespace regraft::bindings {

namespace {

constexpr std::int64_t most_threads = 1024;

std::vector<std::string> available_isas() {
  std::vector<std::string> names;
  for (const simd::Isa isa : simd::available_isas()) names.emplace_back(simd::name(isa));
  return names;
}

simd::Isa checked_isa(const std::string& text) {
  if (text == "auto") return simd::best_isa();
  const auto isa = simd::parse_isa(text);
  if (!isa) {
    throw py::value_error("isa: \"" + text + "\" is none of auto, scalar, sse, avx2, avx512");
  }
  const auto present = simd::available_isas();
  if (std::find(present.begin(), present.end(), *isa) == present.end()) {
    throw py::value_error("isa: this machine has no " + text);
  }
  return *isa;
}

std::unique_ptr<SceneHandle> make_scene(const IntArg& threads, const std::string& isa) {
  const std::int64_t count = checked_int(threads, "threads", 0, most_threads);
  return std::make_unique<SceneHandle>(static_cast<unsigned>(count), checked_isa(isa));
}

void bind_module(py::module_& module) {
  module.doc() = "The native half of regraft; use it through `import regraft`.";
  module.attr("__version__") = REGRAFT_VERSION;
  module.def("available_isas", &available_isas,
             "Instruction sets that this machine has kernels for, weakest first.");
  module.def(
      "best_isa", [] { return std::string(simd::name(simd::best_isa())); },
      "The strongest of `available_isas`, which isa=\"auto\" takes.");
  module.def(
      "hardware_threads", [] { return std::max(1u, std::thread::hardware_concurrency()); },
      "Cores that threads=0 takes.");
  bind_statistics(module);
  bind_results(module);
  bind_point_results(module);
  bind_machine(module);
  bind_node_results(module);
  bind_frame(module);
  SceneClass scene(module, "Scene", R"(A ray-tracing scene that stays alive between frames.

Modify it, call `update`, then trace. Ids are whole numbers and never used twice. Wrong
shapes, dtypes, indices and ids raise ValueError and change nothing; tracing a scene that
changed since its last update raises RuntimeError.)");
  scene.def(py::init(&make_scene), py::arg("threads") = 0, py::kw_only(), py::arg("isa") = "auto",
            R"(threads: how many to work with, this one included; 0: all cores.

isa: auto, scalar, sse, avx2 or avx512; one that the machine lacks raises ValueError.)");
  bind_scene(scene);
  bind_instances(scene);
  bind_update(scene);
  bind_queries(scene);
  bind_points(scene);
  bind_key_frames(scene);
  bind_nodes(scene);
  bind_render(scene);
  bind_kdtree(module);
}

}  // namespace

}  // namespace regraft::bindings

PYBIND11_MODULE(_regraft, module) {
  regraft::bindings::bind_module(module);
}
