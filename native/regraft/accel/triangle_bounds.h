#pragma once

#include "regraft/bvh/box4.h"
#include "regraft/scene/mesh.h"

namespace regraft::accel {

/// Box of a triangle, as refits need it millions of times: `triangle_bounds` of scene/mesh.h in
/// registers. A triangle with a non-finite vertex has the empty box: no ray meets it, and `lost` is
/// called.
template <typename Lost>
bvh::Box4 fast_triangle_bounds(const Mesh& mesh, std::uint32_t t, const Lost& lost) {
  using bvh::Float4;
  using simd::REGRAFT_SIMD_NAMESPACE::load_point;
  const Triangle& corners = mesh.triangles[t];
  const Float4 a = load_point(&mesh.vertices[corners.x].x);
  const Float4 b = load_point(&mesh.vertices[corners.y].x);
  const Float4 c = load_point(&mesh.vertices[corners.z].x);
  // x − x is 0 for finite x and NaN otherwise.
  const Float4 zero = ((a - a) + (b - b)) + (c - c);
  if ((zero == Float4(0.0f)) != 15u) {
    lost();
    return {};
  }
  return {min(min(a, b), c), max(max(a, b), c)};
}

inline bvh::Box4 fast_triangle_bounds(const Mesh& mesh, std::uint32_t t) {
  return fast_triangle_bounds(mesh, t, [] {});
}

}  // namespace regraft::accel
