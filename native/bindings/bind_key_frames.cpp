#include "args.h"
#include "bindings.h"

namespace regraft::bindings {

namespace {

void set_key_vertices(SceneHandle& self, const IntArg& mesh_id, const Float32Arg& frames) {
  const std::uint32_t id = checked_id(mesh_id, "mesh_id");
  const auto array = checked<float>(frames, "frames", {-1, -1, 3});
  const auto count = std::size_t(array.shape(0)), vertices = std::size_t(array.shape(1));
  const std::span<const Vec3> all = elements<Vec3>(array);
  std::vector<std::vector<Vec3>> keys;
  for (std::size_t j = 0; j < count; ++j) {
    const auto frame = all.subspan(j * vertices, vertices);
    keys.emplace_back(frame.begin(), frame.end());
  }
  modifiable(self).set_key_vertices(id, std::move(keys));
}

void set_key_transforms(SceneHandle& self, const IntArg& instance_id, const Float64Arg& frames) {
  const std::uint32_t id = checked_id(instance_id, "instance_id");
  const auto array = checked<double>(frames, "frames", {-1, 4, 4});
  std::vector<Mat4d> keys;
  for (py::ssize_t j = 0; j < array.shape(0); ++j)
    keys.push_back(matrix_from_rows(array.data() + 16 * j));
  modifiable(self).set_key_transforms(id, std::move(keys));
}

}  // namespace

void bind_key_frames(SceneClass& scene) {
  scene
      .def("set_key_vertices", &set_key_vertices, py::arg("mesh_id"), py::arg("frames"),
           R"(Tells where a mesh's vertices will be in key frames of the shot, for policy="shot".

frames: (K, V, 3) float32, object space; eight key frames at most are looked at. No
change of the scene: trees read them when they are built, so give them before the first
update. `set_mesh` forgets them. Raises ValueError for another shape or dtype.)")
      .def("set_key_transforms", &set_key_transforms, py::arg("instance_id"), py::arg("frames"),
           R"(Tells where an instance will be in key frames of the shot, for policy="shot".

frames: (K, 4, 4) float64. As `set_key_vertices`.)");
}

}  // namespace regraft::bindings
