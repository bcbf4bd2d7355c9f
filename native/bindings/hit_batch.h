#pragma once

#include "args.h"
#include "query_arrays.h"
#include "ray_batch.h"

namespace regraft::bindings {

using BoolArray = Arg<"numpy.typing.NDArray[numpy.bool_]">;
using LimitArg = Arg<"float | numpy.typing.NDArray[numpy.float32]">;

/// Hits of N rays, as docs/api.md describes them.
struct HitBatch {
  py::array_t<float> t;
  py::array_t<std::uint32_t> instance_id;
  py::array_t<std::uint32_t> prim_id;
  py::array_t<float> u;
  py::array_t<float> v;
  py::array_t<float> normal;

  explicit HitBatch(py::ssize_t n)
      : t(n), instance_id(n), prim_id(n), u(n), v(n), normal({n, py::ssize_t{3}}) {}

  HitArrays arrays() {
    return {t.mutable_data(), instance_id.mutable_data(), prim_id.mutable_data(),
            u.mutable_data(), v.mutable_data(),           normal.mutable_data()};
  }
};

/// The caller's arrays and how to read them; holds references, so lives with the GIL held.
struct RayArrays {
  py::array origins;
  py::array directions;
  py::object t_near;
  py::object t_far;
  RayBatch batch;
};

/// Throws as `checked_array` does, naming what is wrong.
RayArrays ray_arrays(const RealsArg& origins, const RealsArg& directions, const LimitArg& t_near,
                     const LimitArg& t_far);

}  // namespace regraft::bindings
