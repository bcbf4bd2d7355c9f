#include <limits>

#include "args.h"
#include "bindings.h"
#include "query_arrays.h"
#include "world_normal.h"

namespace regraft::bindings {

namespace {

using trace::PointHit;

/// Points handed to a thread at once.
constexpr std::size_t block = 64;

/// Nearest points to N points, as docs/api.md describes them.
struct PointBatch {
  py::array_t<double> distance;
  py::array_t<double> point;
  py::array_t<std::uint32_t> instance_id;
  py::array_t<std::uint32_t> prim_id;
  py::array_t<float> u;
  py::array_t<float> v;
  py::array_t<float> normal;

  explicit PointBatch(py::ssize_t n)
      : distance(n),
        point({n, py::ssize_t{3}}),
        instance_id(n),
        prim_id(n),
        u(n),
        v(n),
        normal({n, py::ssize_t{3}}) {}
};

/// The memory of a batch, without Python.
struct PointArrays {
  double* distance;
  double* point;
  std::uint32_t* instance_id;
  std::uint32_t* prim_id;
  float* u;
  float* v;
  float* normal;

  explicit PointArrays(PointBatch& batch)
      : distance(batch.distance.mutable_data()),
        point(batch.point.mutable_data()),
        instance_id(batch.instance_id.mutable_data()),
        prim_id(batch.prim_id.mutable_data()),
        u(batch.u.mutable_data()),
        v(batch.v.mutable_data()),
        normal(batch.normal.mutable_data()) {}

  void store(std::size_t i, const PointHit& hit, const Vec3& facing) const {
    distance[i] = hit.distance;
    instance_id[i] = hit.instance_id;
    prim_id[i] = hit.prim_id;
    u[i] = hit.u;
    v[i] = hit.v;
    for (std::size_t k = 0; k < 3; ++k) {
      point[3 * i + k] = hit.point[int(k)];
      normal[3 * i + k] = facing[int(k)];
    }
  }
};

double checked_reach(const Arg<"float">& object) {
  const double reach = checked_number(object, "max_distance");
  if (reach >= 0.0) return reach;
  throw py::value_error("max_distance: a number of at least 0 wanted");
}

PointBatch closest_point(SceneHandle& self, const RealsArg& points, const Arg<"float">& reach) {
  const py::array array = real_array(points, "points", -1);
  const double max_distance = checked_reach(reach);
  const Rows from = rows(array);
  const auto count = static_cast<std::size_t>(array.shape(0));
  const Tracing tracing(self);
  PointBatch batch(array.shape(0));
  const PointArrays out(batch);
  const Scene& scene = self.renderer.scene();
  const auto work = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * block; i < std::min(count, end * block); ++i) {
      const PointHit hit = tracing.tracer().closest_point(from.at(i), max_distance);
      const bool found = hit.instance_id != invalid_id;
      out.store(i, hit, found ? world_normal(scene, hit.instance_id, hit.prim_id) : Vec3(0.0f));
    }
  };
  for_blocks(self.renderer.executor(), (count + block - 1) / block, Sharing{1, 256, 1}, work);
  return batch;
}

}  // namespace

void bind_point_results(py::module_& module) {
  py::class_<PointBatch>(module, "PointBatch", "Nearest points to N points, one element a point.")
      .def_readonly("distance", &PointBatch::distance,
                    "(N,) float64, world units; inf: nothing within reach.")
      .def_readonly("point", &PointBatch::point, "(N, 3) float64, world frame; zero: nothing.")
      .def_readonly("instance_id", &PointBatch::instance_id, "(N,) uint32; 0xFFFFFFFF: nothing.")
      .def_readonly("prim_id", &PointBatch::prim_id,
                    "(N,) uint32, the triangle of the instance's mesh; 0xFFFFFFFF: nothing.")
      .def_readonly("u", &PointBatch::u, "(N,) float32, weight of the triangle's second vertex.")
      .def_readonly("v", &PointBatch::v, "(N,) float32, weight of the triangle's third vertex.")
      .def_readonly("normal", &PointBatch::normal,
                    "(N, 3) float32, geometric unit normal in the world frame, facing as the "
                    "placed triangle is wound; zero: nothing.")
      .def("__len__", [](const PointBatch& batch) { return batch.distance.shape(0); });
}

void bind_points(SceneClass& scene) {
  scene.def("closest_point", &closest_point, py::arg("points"),
            py::arg("max_distance") = py::float_(std::numeric_limits<double>::infinity()),
            R"(Nearest point of the scene's surfaces to each of N points.

points: (N, 3) float32 or float64, world frame. max_distance: how far to look, world units.
Points that are not finite find nothing. Among equally near triangles the lowest
(instance_id, prim_id) counts. Distances are computed in double. Releases the GIL.

Raises ValueError for another shape or dtype or a negative distance, RuntimeError if the
scene changed since its last update.)");
}

}  // namespace regraft::bindings
