#include <pybind11/stl.h>

#include <optional>

#include "args.h"
#include "bindings.h"

namespace regraft::bindings {

namespace {

using MaterialListsArg =
    Arg<"collections.abc.Sequence[int] | collections.abc.Sequence[collections.abc.Sequence[int]]">;

std::vector<Mat4d> checked_matrices(const py::object& object, std::size_t count) {
  const auto array = checked<double>(object, "transforms", {static_cast<py::ssize_t>(count), 4, 4});
  std::vector<Mat4d> matrices(count);
  for (std::size_t i = 0; i < count; ++i) matrices[i] = matrix_from_rows(array.data() + 16 * i);
  return matrices;
}

std::uint32_t material_list(Scene& scene, const py::object& ids) {
  return scene.material_list(checked_ids(ids, "materials"));
}

/// A list id for each of `count` instances: from one tuple for all, or from a sequence of theirs.
std::vector<std::uint32_t> material_lists(Scene& scene, const MaterialListsArg& lists,
                                          std::size_t count) {
  if (py::isinstance<py::tuple>(lists)) return std::vector(count, material_list(scene, lists));
  if (!py::isinstance<py::sequence>(lists) || py::len(lists) != count) {
    throw py::value_error("materials: one tuple of ids for all, or a list of " +
                          std::to_string(count) + " of them wanted");
  }
  std::vector<std::uint32_t> result;
  py::object last = py::none();
  for (const py::handle item : lists) {
    // Bulk callers pass the same object again and again.
    if (!item.is(last)) {
      last = py::reinterpret_borrow<py::object>(item);
      result.push_back(material_list(scene, last));
    } else {
      result.push_back(result.back());
    }
  }
  return result;
}

std::uint32_t add_instance(SceneHandle& self, const IntArg& mesh_id,
                           const std::optional<Float64Arg>& transform,
                           const std::optional<IntArg>& group, const std::string& name,
                           const std::optional<IdsArg>& materials, const IntArg& object_index) {
  Scene& scene = modifiable(self);
  Instance instance;
  instance.name = name;
  instance.mesh = checked_id(mesh_id, "mesh_id");
  if (transform) instance.object_to_world = checked_matrix(*transform, "transform");
  if (group) instance.group = checked_id(*group, "group");
  if (materials) instance.material_list = material_list(scene, *materials);
  instance.object_index = checked_id(object_index, "object_index");
  return scene.add_instance(std::move(instance));
}

py::array_t<std::uint32_t> add_instances(SceneHandle& self, const Uint32Arg& mesh_ids,
                                         const Float64Arg& transforms,
                                         const std::optional<Uint32Arg>& groups,
                                         const std::optional<MaterialListsArg>& materials,
                                         const std::optional<Uint32Arg>& object_indices) {
  Scene& scene = modifiable(self);
  const auto meshes = checked<std::uint32_t>(mesh_ids, "mesh_ids", {-1});
  const auto count = static_cast<std::size_t>(meshes.size());
  const std::vector<Mat4d> matrices = checked_matrices(transforms, count);
  std::vector<Instance> instances(count);
  for (std::size_t i = 0; i < count; ++i) {
    instances[i].mesh = meshes.data()[i];
    instances[i].object_to_world = matrices[i];
  }
  const auto fill = [&](const auto& arg, const char* name, std::uint32_t Instance::*member) {
    if (!arg) return;
    const auto values = checked<std::uint32_t>(*arg, name, {meshes.size()});
    for (std::size_t i = 0; i < count; ++i) instances[i].*member = values.data()[i];
  };
  fill(groups, "groups", &Instance::group);
  fill(object_indices, "object_indices", &Instance::object_index);
  if (materials) {
    const auto lists = material_lists(scene, *materials, count);
    for (std::size_t i = 0; i < count; ++i) instances[i].material_list = lists[i];
  }
  const std::uint32_t first = scene.add_instances(std::move(instances));
  py::array_t<std::uint32_t> ids(meshes.size());
  for (std::size_t i = 0; i < count; ++i) {
    ids.mutable_data()[i] = first + static_cast<std::uint32_t>(i);
  }
  return ids;
}

void set_transform(SceneHandle& self, const IntArg& instance_id, const Float64Arg& m) {
  const std::uint32_t id = checked_id(instance_id, "instance_id");
  modifiable(self).set_transform(id, checked_matrix(m, "m"));
}

void set_transforms(SceneHandle& self, const IdsArg& ids, const Float64Arg& transforms) {
  const std::vector<std::uint32_t> instances = checked_ids(ids, "ids");
  modifiable(self).set_transforms(instances, checked_matrices(transforms, instances.size()));
}

void set_visible(SceneHandle& self, const IntArg& instance_id, bool flag) {
  modifiable(self).set_visible(checked_id(instance_id, "instance_id"), flag);
}

void set_instance_materials(SceneHandle& self, const IntArg& instance_id, const IdsArg& ids) {
  Scene& scene = modifiable(self);
  scene.set_material_list(checked_id(instance_id, "instance_id"), material_list(scene, ids));
}

void remove_instance(SceneHandle& self, const IntArg& instance_id) {
  modifiable(self).remove_instance(checked_id(instance_id, "instance_id"));
}

void remove_instances(SceneHandle& self, const IdsArg& ids) {
  modifiable(self).remove_instances(checked_ids(ids, "ids"));
}

}  // namespace

void bind_instances(SceneClass& scene) {
  scene
      .def("add_instance", &add_instance, py::arg("mesh_id"), py::arg("transform") = py::none(),
           py::kw_only(), py::arg("group") = py::none(), py::arg("name") = "",
           py::arg("materials") = py::none(), py::arg("object_index") = 0,
           R"(Places a mesh in the world and returns the instance's id.

transform: (4, 4) float64, object to world, column vectors, last row 0 0 0 1; None:
identity. One that is not finite is taken, but cannot be hit.
materials: material ids, one a slot of the mesh; slots without one have the standard
material.
object_index: what the pass of that name shows.

Raises ValueError if the mesh or the group does not exist.)")
      .def("add_instances", &add_instances, py::arg("mesh_ids"), py::arg("transforms"),
           py::kw_only(), py::arg("groups") = py::none(), py::arg("materials") = py::none(),
           py::arg("object_indices") = py::none(),
           R"(Places N meshes in the world and returns the instances' ids, (N,) uint32.

mesh_ids: (N,) uint32; transforms: (N, 4, 4) float64, object to world; groups: (N,)
uint32, 0xFFFFFFFF for none; materials: one tuple of ids for all, or a list of N;
object_indices: (N,) uint32. Raises ValueError, and adds none, if one of them is wrong.)")
      .def("set_transform", &set_transform, py::arg("instance_id"), py::arg("m"),
           R"(Moves an instance; m: (4, 4) float64, object to world, column vectors.

A matrix equal bit for bit to the present one is no change.)")
      .def("set_transforms", &set_transforms, py::arg("ids"), py::arg("transforms"),
           R"(Moves N instances: ids (N,) uint32, transforms (N, 4, 4) float64, object to world.

Raises ValueError, and moves none, if one of them is wrong.)")
      .def("set_visible", &set_visible, py::arg("instance_id"), py::arg("flag"),
           R"(Hides or shows an instance. A hidden one keeps its mesh's tree.)")
      .def("set_instance_materials", &set_instance_materials, py::arg("instance_id"),
           py::arg("ids"), R"(Gives an instance other materials, one id a slot of its mesh.)")
      .def("remove_instance", &remove_instance, py::arg("instance_id"),
           R"(Removes an instance. Its id is never used again.)")
      .def("remove_instances", &remove_instances, py::arg("ids"),
           R"(Removes instances: ids (N,) uint32.

Raises ValueError, and removes none, if an id is wrong or given twice.)");
}

}  // namespace regraft::bindings
