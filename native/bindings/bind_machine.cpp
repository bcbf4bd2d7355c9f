#include "args.h"
#include "bindings.h"
#include "machine_costs.h"
#include "regraft/render/calibration.h"

namespace regraft::bindings {

namespace {

using NumberDict = Arg<"dict[str, float]">;

NumberDict as_numbers(const MachineCosts& costs) {
  return as<NumberDict>(py::dict(py::arg("leaf") = costs.leaf, py::arg("rebuild") = costs.rebuild,
                                 py::arg("refine") = costs.refine,
                                 py::arg("morton") = costs.morton));
}

/// A cost, or what it was if None.
double taken(const py::object& object, const char* name, double before) {
  if (object.is_none()) return before;
  const double cost = checked_number(object, name);
  if (cost > 0.0 && cost < 1e9) return cost;
  throw py::value_error(std::string(name) + ": a number above 0 and below 1e9 wanted");
}

NumberDict set_machine_costs(const py::object& leaf, const py::object& rebuild,
                             const py::object& refine, const py::object& morton) {
  MachineCosts costs = machine_costs();
  costs = {taken(leaf, "leaf", costs.leaf), taken(rebuild, "rebuild", costs.rebuild),
           taken(refine, "refine", costs.refine), taken(morton, "morton", costs.morton)};
  machine_costs() = costs;
  return as_numbers(costs);
}

NumberDict calibrate(const IntArg& threads) {
  const auto count = static_cast<unsigned>(checked_int(threads, "threads", 0, 1024));
  MachineCosts costs;
  {
    const py::gil_scoped_release no_gil;
    Executor executor(count);
    costs = render::calibrate(executor, simd::best_isa());
  }
  return as_numbers(costs);
}

}  // namespace

MachineCosts& machine_costs() {
  static MachineCosts costs = [] {
    const bvh::RestructureConfig defaults;
    return MachineCosts{bvh::CostModel{}.leaf, defaults.rebuild, defaults.refine, defaults.morton};
  }();
  return costs;
}

void bind_machine(py::module_& module) {
  module.def(
      "machine_costs", [] { return as_numbers(machine_costs()); },
      R"(What updates take operations for, in units of one expected test of a ray: `leaf`, a
triangle test; `rebuild`, a build of m triangles divided by m log2 m; `refine`, looking at one
pair of nodes; `morton`, a quick build divided by m.)");
  module.def(
      "set_machine_costs", &set_machine_costs, py::kw_only(), py::arg("leaf") = py::none(),
      py::arg("rebuild") = py::none(), py::arg("refine") = py::none(),
      py::arg("morton") = py::none(),
      R"(Changes what None does not leave as it is, for all scenes of the process; returns all.

Raises ValueError for a cost that is not a number above 0 and below 1e9.)");
  module.def("calibrate", &calibrate, py::arg("threads") = 0,
             R"(Measures the machine costs, and changes nothing. Takes a few seconds; releases the
GIL.)");
}

}  // namespace regraft::bindings
