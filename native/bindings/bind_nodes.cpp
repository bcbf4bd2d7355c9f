#include <algorithm>

#include "bindings.h"
#include "hit_batch.h"

namespace regraft::bindings {

namespace {

/// Nodes of the trees, as docs/api.md describes them.
struct NodeBatch {
  py::array_t<double> boxes;
  py::array_t<double> damage;
  py::array_t<bool> rebuilt;

  explicit NodeBatch(const accel::NodeBatch& nodes)
      : boxes({py::ssize_t(nodes.boxes.size()), py::ssize_t{2}, py::ssize_t{3}}),
        damage(py::ssize_t(nodes.damage.size()), nodes.damage.data()),
        rebuilt(py::ssize_t(nodes.rebuilt.size())) {
    for (std::size_t i = 0; i < nodes.boxes.size(); ++i) {
      std::copy_n(nodes.boxes[i].data(), 6, boxes.mutable_data() + 6 * i);
      rebuilt.mutable_data()[i] = nodes.rebuilt[i] != 0;
    }
  }
};

NodeBatch damaged_nodes(SceneHandle& self, const IntArg& depth) {
  const auto levels = std::uint32_t(checked_int(depth, "depth", 0, 2 * bvh::max_depth));
  const Tracing tracing(self);
  return NodeBatch(self.renderer.accelerator().nodes_at(levels));
}

NodeBatch rebuilt_nodes(SceneHandle& self) {
  const Tracing tracing(self);
  return NodeBatch(self.renderer.accelerator().rebuilt_nodes());
}

}  // namespace

void bind_node_results(py::module_& module) {
  py::class_<NodeBatch>(module, "NodeBatch", "Nodes of the trees, one element a node.")
      .def_readonly("boxes", &NodeBatch::boxes,
                    "(N, 2, 3) float64, world frame: lowest and highest corners.")
      .def_readonly("damage", &NodeBatch::damage,
                    "(N,) float64: tests lost since the node was last in order, as a share of all "
                    "that it costs; 0 where the policy does not measure.")
      .def_property_readonly(
          "rebuilt", [](const NodeBatch& batch) { return as<BoolArray>(batch.rebuilt); },
          "(N,) bool: made anew by the last update that had something to do, or holding nodes that "
          "were.")
      .def("__len__", [](const NodeBatch& batch) { return batch.damage.shape(0); });
}

void bind_nodes(SceneClass& scene) {
  scene
      .def("damaged_nodes", &damaged_nodes, py::arg("depth"),
           R"(The nodes `depth` levels below the root, with leaves that end above, and their damage.

Levels are counted through the top tree into those of the meshes, once an instance.

Raises RuntimeError if the scene changed since its last update.)")
      .def("rebuilt_nodes", &rebuilt_nodes,
           R"(The highest nodes that the last update which had something to do made anew.

Raises RuntimeError if the scene changed since its last update.)");
}

}  // namespace regraft::bindings
