#include <limits>

#include "args.h"
#include "bindings.h"
#include "hit_batch.h"
#include "ray_order.h"

namespace regraft::bindings {

namespace {

void sort(RayBatch& batch, AlignedVector<bvh::KeyedId>& order, SceneHandle& self) {
  const py::gil_scoped_release no_gil;
  sort_rays(batch, order, self.renderer.executor());
}

template <Search search>
HitBatch closest_hit(SceneHandle& self, const RealsArg& origins, const RealsArg& directions,
                     const LimitArg& t_near, const LimitArg& t_far) {
  RayArrays rays = ray_arrays(origins, directions, t_near, t_far);
  const Tracing tracing(self);
  AlignedVector<bvh::KeyedId> order;
  if (search == Search::trees) sort(rays.batch, order, self);
  HitBatch hits(rays.origins.shape(0));
  const HitArrays arrays = hits.arrays();
  const Scene& scene = self.renderer.scene();
  const Sharing sharing = search == Search::trees ? Sharing{} : Sharing{0, 0, 1};
  for_blocks(self.renderer.executor(), rays.batch.packet_count(), sharing,
             [&](std::size_t begin, std::size_t end) {
               trace_closest(rays.batch, tracing.tracer(), scene, search, begin, end, arrays);
             });
  if (search == Search::trees) self.renderer.note_rays(rays.batch.count);
  return hits;
}

BoolArray any_hit(SceneHandle& self, const RealsArg& origins, const RealsArg& directions,
                  const LimitArg& t_near, const LimitArg& t_far) {
  RayArrays rays = ray_arrays(origins, directions, t_near, t_far);
  const Tracing tracing(self);
  AlignedVector<bvh::KeyedId> order;
  sort(rays.batch, order, self);
  py::array_t<bool> hit(rays.origins.shape(0));
  bool* out = hit.mutable_data();
  for_blocks(self.renderer.executor(), rays.batch.packet_count(), Sharing{},
             [&](std::size_t begin, std::size_t end) {
               trace_any(rays.batch, tracing.tracer(), begin, end, out);
             });
  self.renderer.note_rays(rays.batch.count);
  return as<BoolArray>(hit);
}

}  // namespace

void bind_results(py::module_& module) {
  py::class_<HitBatch>(module, "HitBatch", "Nearest hits of N rays, one element a ray.")
      .def_readonly("t", &HitBatch::t,
                    "(N,) float32, in units of the direction's length; inf: a miss.")
      .def_readonly("instance_id", &HitBatch::instance_id, "(N,) uint32; 0xFFFFFFFF: a miss.")
      .def_readonly("prim_id", &HitBatch::prim_id,
                    "(N,) uint32, the triangle of the instance's mesh; 0xFFFFFFFF: a miss.")
      .def_readonly("u", &HitBatch::u, "(N,) float32, weight of the triangle's second vertex.")
      .def_readonly("v", &HitBatch::v, "(N,) float32, weight of the triangle's third vertex.")
      .def_readonly("normal", &HitBatch::normal,
                    "(N, 3) float32, geometric unit normal in the world frame, facing as the "
                    "placed triangle is wound; zero: a miss.")
      .def("__len__", [](const HitBatch& hits) { return hits.t.shape(0); });
}

void bind_queries(SceneClass& scene) {
  const auto no_limit = py::float_(std::numeric_limits<double>::infinity());
  scene
      .def("closest_hit", &closest_hit<Search::trees>, py::arg("origins"), py::arg("directions"),
           py::arg("t_near") = 0.0, py::arg("t_far") = no_limit,
           R"(Nearest hit of each of N rays in [t_near, t_far].

origins, directions: (N, 3) float32 or float64, world frame; directions need not be unit
vectors.
t_near, t_far: a number or (N,) float32, in units of the direction's length. Rays that are
not finite, or whose direction is zero, miss. Among equally near hits the lowest
(instance_id, prim_id) counts. Large batches are traced in an order of their own, so theirs
does not matter. Releases the GIL.

Raises ValueError for another shape or dtype, RuntimeError if the scene changed since its
last update.)")
      .def("closest_hit_brute_force", &closest_hit<Search::brute_force>, py::arg("origins"),
           py::arg("directions"), py::arg("t_near") = 0.0, py::arg("t_far") = no_limit,
           R"(`closest_hit` without any tree: every ray against every triangle.

For checks: whatever the policy, structure and layout, `closest_hit` returns these very
bits. Takes about a nanosecond a ray and triangle.)")
      .def("any_hit", &any_hit, py::arg("origins"), py::arg("directions"), py::arg("t_near") = 0.0,
           py::arg("t_far") = no_limit,
           R"(Whether each of N rays hits anything in [t_near, t_far]: (N,) bool.

Arguments and errors as for `closest_hit`.)");
}

}  // namespace regraft::bindings
