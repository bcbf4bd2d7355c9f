#pragma once

#include "regraft/scene/mesh.h"
#include "regraft/simd/gather.h"

namespace regraft::accel {

/// Box of a triangle, as refits need it millions of times: `triangle_bounds` of scene/mesh.h in
/// registers. A triangle with a non-finite vertex has the empty box: no ray meets it.
inline Aabb fast_triangle_bounds(const Mesh& mesh, std::uint32_t t) {
  using simd::REGRAFT_SIMD_NAMESPACE::load_point;
  using Float4 = simd::REGRAFT_SIMD_NAMESPACE::Float<4>;
  const Triangle& corners = mesh.triangles[t];
  const Float4 a = load_point(&mesh.vertices[corners.x].x);
  const Float4 b = load_point(&mesh.vertices[corners.y].x);
  const Float4 c = load_point(&mesh.vertices[corners.z].x);
  // x − x is 0 for finite x and NaN otherwise.
  const Float4 zero = ((a - a) + (b - b)) + (c - c);
  if ((zero == Float4(0.0f)) != 15u) return {};
  alignas(16) float lo[4], hi[4];
  min(min(a, b), c).store(lo);
  max(max(a, b), c).store(hi);
  return {Vec3(lo[0], lo[1], lo[2]), Vec3(hi[0], hi[1], hi[2])};
}

}  // namespace regraft::accel
