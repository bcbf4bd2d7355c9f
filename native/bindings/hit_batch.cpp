#include "hit_batch.h"

namespace regraft::bindings {

namespace {

Limits limits(const py::object& object, const char* name, py::ssize_t count) {
  if (!py::isinstance<py::array>(object) || py::cast<py::array>(object).ndim() == 0) {
    return {static_cast<float>(checked_number(object, name)), nullptr, 0};
  }
  const py::array array = checked_array(object, name, {py::dtype::of<float>()}, {count});
  return {0.0f, static_cast<const std::byte*>(array.data()), array.strides(0)};
}

}  // namespace

RayArrays ray_arrays(const RealsArg& origins, const RealsArg& directions, const LimitArg& t_near,
                     const LimitArg& t_far) {
  RayArrays rays{real_array(origins, "origins", -1), {}, t_near, t_far, {}};
  const py::ssize_t count = rays.origins.shape(0);
  rays.directions = real_array(directions, "directions", count);
  rays.batch = {rows(rays.origins), rows(rays.directions), limits(t_near, "t_near", count),
                limits(t_far, "t_far", count), static_cast<std::size_t>(count)};
  return rays;
}

}  // namespace regraft::bindings
