#include <pybind11/stl.h>

#include <optional>

#include "args.h"
#include "bindings.h"
#include "read_dataclass.h"
#include "scene_handle.h"

namespace regraft::bindings {

namespace {

using CountDict = Arg<"dict[str, int]">;
using OptionalId = std::optional<IntArg>;

/// The arrays of a mesh, kept alive while `MeshData` points at them.
struct MeshArrays {
  Array<float> vertices;
  Array<std::uint32_t> triangles;
  Array<std::uint16_t> slots;
  Array<std::uint32_t> normal_ids;

  MeshData data() const {
    return {elements<Vec3>(vertices), elements<Triangle>(triangles), elements<std::uint16_t>(slots),
            elements<glm::uvec3>(normal_ids)};
  }
};

MeshArrays mesh_arrays(const Float32Arg& vertices, const Uint32Arg& triangles,
                       const std::optional<Uint16Arg>& slots,
                       const std::optional<Uint32Arg>& normal_ids, const std::string& label) {
  MeshArrays arrays;
  arrays.vertices = checked<float>(vertices, label + "vertices", {-1, 3});
  arrays.triangles = checked<std::uint32_t>(triangles, label + "triangles", {-1, 3});
  const py::ssize_t count = arrays.triangles.shape(0);
  if (slots) arrays.slots = checked<std::uint16_t>(*slots, label + "slots", {count});
  if (normal_ids) {
    arrays.normal_ids = checked<std::uint32_t>(*normal_ids, label + "normal_ids", {count, 3});
  }
  return arrays;
}

std::uint32_t add_mesh(SceneHandle& self, const Float32Arg& vertices, const Uint32Arg& triangles,
                       const std::string& name, const std::optional<Uint16Arg>& slots,
                       const std::optional<Uint32Arg>& normal_ids) {
  const std::string label = name.empty() ? "" : "mesh \"" + name + "\": ";
  const MeshArrays arrays = mesh_arrays(vertices, triangles, slots, normal_ids, label);
  return modifiable(self).add_mesh(arrays.data(), name);
}

/// `mesh 3 "Cube": `, or nothing where there is no such mesh: the scene will say so.
std::string mesh_label(const Scene& scene, std::uint32_t id) {
  if (id >= scene.meshes().size() || !scene.meshes()[id].alive) return "";
  return label(scene.meshes()[id], id) + ": ";
}

void set_vertices(SceneHandle& self, const IntArg& mesh_id, const Float32Arg& vertices) {
  Scene& scene = modifiable(self);
  const std::uint32_t id = checked_id(mesh_id, "mesh_id");
  const auto array = checked<float>(vertices, mesh_label(scene, id) + "vertices", {-1, 3});
  scene.set_vertices(id, elements<Vec3>(array));
}

void set_mesh(SceneHandle& self, const IntArg& mesh_id, const Float32Arg& vertices,
              const Uint32Arg& triangles, const std::optional<Uint16Arg>& slots,
              const std::optional<Uint32Arg>& normal_ids) {
  Scene& scene = modifiable(self);
  const std::uint32_t id = checked_id(mesh_id, "mesh_id");
  const MeshArrays arrays =
      mesh_arrays(vertices, triangles, slots, normal_ids, mesh_label(scene, id));
  scene.set_mesh(id, arrays.data());
}

void remove_mesh(SceneHandle& self, const IntArg& mesh_id) {
  modifiable(self).remove_mesh(checked_id(mesh_id, "mesh_id"));
}

std::uint32_t add_group(SceneHandle& self, const OptionalId& parent, const std::string& name) {
  const std::uint32_t above = parent ? checked_id(*parent, "parent") : invalid_id;
  return modifiable(self).add_group(above, name);
}

/// The one colour table of the scene, a row a material.
void set_materials(SceneHandle& self, const Float32Arg& base_color,
                   const std::optional<Float32Arg>& metallic,
                   const std::optional<Float32Arg>& roughness,
                   const std::optional<Float32Arg>& emission) {
  const auto colors = checked<float>(base_color, "base_color", {-1, 4});
  const py::ssize_t count = colors.shape(0);
  std::vector<Material> materials(static_cast<std::size_t>(count));
  const auto fill = [&](const auto& arg, const char* name, const Shape& shape, auto&& assign) {
    if (!arg) return;
    const auto array = checked<float>(*arg, name, shape);
    const std::size_t width = shape.size() == 1 ? 1 : 3;
    for (std::size_t i = 0; i < materials.size(); ++i) {
      assign(materials[i], array.data() + i * width);
    }
  };
  for (std::size_t i = 0; i < materials.size(); ++i) {
    materials[i].base_color = elements<Vec4>(colors)[i];
  }
  fill(metallic, "metallic", {count}, [](Material& m, const float* v) { m.metallic = *v; });
  fill(roughness, "roughness", {count}, [](Material& m, const float* v) { m.roughness = *v; });
  fill(emission, "emission", {count, 3}, [](Material& m, const float* v) {
    m.emission = {v[0], v[1], v[2]};
  });
  modifiable(self).set_materials(std::move(materials));
}

void set_lights(SceneHandle& self, const LightsArg& lights) {
  modifiable(self).set_lights(read_lights(lights));
}

void set_world(SceneHandle& self, const FloatsArg& color) {
  const auto rgb = checked_numbers<3>(color, "color");
  modifiable(self).set_world(Vec3(rgb[0], rgb[1], rgb[2]));
}

CountDict counts(const SceneHandle& self) {
  const Scene& scene = self.renderer.scene();
  std::size_t meshes = 0, triangles = 0, instances = 0;
  for (const Mesh& mesh : scene.meshes()) {
    meshes += mesh.alive;
    triangles += mesh.triangles.size();
  }
  for (const Instance& instance : scene.instances()) instances += instance.alive;
  return as<CountDict>(py::dict(py::arg("meshes") = meshes, py::arg("instances") = instances,
                                py::arg("groups") = scene.groups().size(),
                                py::arg("triangles") = triangles));
}

}  // namespace

void bind_scene(SceneClass& scene) {
  scene
      .def("add_mesh", &add_mesh, py::arg("vertices"), py::arg("triangles"), py::kw_only(),
           py::arg("name") = "", py::arg("slots") = py::none(), py::arg("normal_ids") = py::none(),
           R"(Adds a mesh and returns its id.

vertices: (V, 3) float32, object space; triangles: (T, 3) uint32, vertex indices.
slots: (T,) uint16, the material slot of each triangle; None: all 0.
normal_ids: (T, 3) uint32; corners that share a number share a shading normal, 0xFFFFFFFF
marks a flat corner, None: the whole mesh is flat, `triangles` itself: the whole mesh is
smooth. Numbers lie below V, or below 3 T if that is more.

Triangles with a vertex that is not finite, and those of zero area, cannot be hit;
`update` counts them in its warnings. Raises ValueError for another shape or dtype or an
index out of range.)")
      .def("set_vertices", &set_vertices, py::arg("mesh_id"), py::arg("vertices"),
           R"(Moves a mesh's vertices, keeping its triangles: the tree can be refitted.

vertices: (V, 3) float32, object space, as many as the mesh has. Positions equal bit for
bit to the present ones are no change. Raises ValueError for another count, shape or
dtype.)")
      .def("set_mesh", &set_mesh, py::arg("mesh_id"), py::arg("vertices"), py::arg("triangles"),
           py::kw_only(), py::arg("slots") = py::none(), py::arg("normal_ids") = py::none(),
           R"(Replaces the whole content of a mesh; its id, name and instances stay.

Arguments as for `add_mesh`. Raises ValueError, and changes nothing, if one of them is
wrong.)")
      .def("remove_mesh", &remove_mesh, py::arg("mesh_id"),
           R"(Removes a mesh. Its id is never used again.

Raises ValueError while instances use it.)")
      .def("add_group", &add_group, py::arg("parent") = py::none(), py::kw_only(),
           py::arg("name") = "",
           R"(Adds a level of the scene's hierarchy (a collection, a parent) and returns its id.

Groups carry no transform. Raises ValueError if the parent group does not exist.)")
      .def("set_materials", &set_materials, py::arg("base_color"), py::arg("metallic") = py::none(),
           py::arg("roughness") = py::none(), py::arg("emission") = py::none(),
           R"(Replaces the scene's table of materials; a material's id is its row.

base_color: (M, 4) float32, linear RGBA; metallic, roughness: (M,) float32, 0 and 0.5 if
None; emission: (M, 3) float32, linear radiance, black if None.)")
      .def("set_lights", &set_lights, py::arg("lights"),
           R"(Replaces the scene's lights by a sequence of `regraft.Light`.

With none at all the camera carries a headlight.)")
      .def("set_world", &set_world, py::arg("color"),
           R"(Sets the background radiance, three numbers, linear RGB.

It is also the ambient light of `direct` shading.)")
      .def("counts", &counts,
           R"(Numbers of `meshes`, `instances`, `groups` and `triangles` (of meshes) that exist.)");
}

}  // namespace regraft::bindings
