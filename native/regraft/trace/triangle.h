#pragma once

#include <cstdint>

#include "regraft/simd/gather.h"
#include "regraft/trace/local_ray.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

using simd::REGRAFT_SIMD_NAMESPACE::Float;
using simd::REGRAFT_SIMD_NAMESPACE::LaneBits;
using Float4 = Float<4>;

/// The nearest hit so far of one ray. Before the first: t = t_far and ids invalid.
struct Nearest {
  float t;
  std::uint32_t instance_id;
  std::uint32_t prim_id;
  float u;
  float v;

  /// Smallest t, then smallest (instance, primitive): the answer does not depend on the order
  /// in which primitives are met.
  REGRAFT_INLINE bool beaten_by(float other_t, std::uint32_t instance, std::uint32_t prim) const {
    if (other_t != t) return other_t < t;
    return instance != instance_id ? instance < instance_id : prim < prim_id;
  }
};

/// Watertight test (Woop, Benthin, Wald, JCGT 2013) of the axis KZ: edge functions, determinant
/// and scaled distance of N (ray, triangle) pairs. Corners are given relative to the ray's
/// origin, sheared axes first. Needs `-ffp-contract=off`: fused edge functions open cracks.
template <int N>
struct EdgeTest {
  Float<N> u, v, w, det, t;
  LaneBits hit;

  REGRAFT_INLINE EdgeTest(const Float<N> (&a)[3], const Float<N> (&b)[3], const Float<N> (&c)[3],
                          Float<N> sx, Float<N> sy, Float<N> sz) {
    const Float<N> ax = a[0] - sx * a[2], ay = a[1] - sy * a[2];
    const Float<N> bx = b[0] - sx * b[2], by = b[1] - sy * b[2];
    const Float<N> cx = c[0] - sx * c[2], cy = c[1] - sy * c[2];
    u = cx * by - cy * bx;
    v = ax * cy - ay * cx;
    w = bx * ay - by * ax;
    const Float<N> zero(0.0f);
    const LaneBits on_edge = (u == zero) | (v == zero) | (w == zero);
    if (on_edge != 0) recompute(ax, ay, bx, by, cx, cy, on_edge);
    const LaneBits negative = (u < zero) | (v < zero) | (w < zero);
    const LaneBits positive = (zero < u) | (zero < v) | (zero < w);
    det = (u + v) + w;
    t = ((u * (sz * a[2]) + v * (sz * b[2])) + w * (sz * c[2])) / det;
    // A determinant of zero or NaN is neither below nor above zero.
    hit = ~(negative & positive) & ((det < zero) | (zero < det));
  }

 private:
  /// The sign of a product difference can be lost in float but not in double: both products
  /// of two floats are exact there.
  REGRAFT_INLINE void recompute(Float<N> ax, Float<N> ay, Float<N> bx, Float<N> by, Float<N> cx,
                                Float<N> cy, LaneBits lanes) {
    alignas(64) float p[6][N], e[3][N];
    ax.store(p[0]), ay.store(p[1]), bx.store(p[2]), by.store(p[3]), cx.store(p[4]), cy.store(p[5]);
    u.store(e[0]), v.store(e[1]), w.store(e[2]);
    for (int i = 0; i < N; ++i) {
      if ((lanes >> i & 1u) == 0) continue;
      const double dax = p[0][i], day = p[1][i], dbx = p[2][i];
      const double dby = p[3][i], dcx = p[4][i], dcy = p[5][i];
      e[0][i] = float(dcx * dby - dcy * dbx);
      e[1][i] = float(dax * dcy - day * dcx);
      e[2][i] = float(dbx * day - dby * dax);
    }
    u = Float<N>::load(e[0]), v = Float<N>::load(e[1]), w = Float<N>::load(e[2]);
  }
};

/// Where N rays are inside the boxes of N triangles; same rounding as `box_interval`. `near`
/// and `far` say on which side of the triangle each plane lies, by the sign of the inverse.
template <int N>
REGRAFT_INLINE void widen_axis(Float<N> near_plane, Float<N> far_plane, Float<N> near_origin,
                               Float<N> far_origin, Float<N> inverse, Float<N>& near,
                               Float<N>& far) {
  near = max((near_plane - near_origin) * inverse, near);
  far = min((far_plane - far_origin) * inverse, far);
}

/// Tests `count` (1–4) triangles of a mesh against a ray; for each hit calls
/// `accept(lane, world_t, u, v)` in lane order.
///
/// t is clamped to the triangle's own box: what the tree compares against box intervals then
/// never lies before the box of any ancestor, whatever the rounding, so no order of traversal
/// can hide it.
template <int KZ, typename Accept>
REGRAFT_INLINE void test_triangles(const LocalRay& ray, const MeshView& mesh,
                                   const std::uint32_t* prims, int count, float limit,
                                   const Accept& accept) {
  constexpr int KX = (KZ + 1) % 3;
  constexpr int KY = (KZ + 2) % 3;
  std::uint32_t index[3][4];
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t* corners = mesh.triangles + 3 * std::size_t(prims[i < count ? i : 0]);
    for (int c = 0; c < 3; ++c) index[c][i] = corners[c];
  }
  Float4 corner[3][3];
  for (int c = 0; c < 3; ++c) {
    const auto p = simd::REGRAFT_SIMD_NAMESPACE::gather_points(mesh.vertices, index[c]);
    for (int k = 0; k < 3; ++k) corner[c][k] = p.x[k];
  }
  Float4 relative[3][3];
  for (int c = 0; c < 3; ++c) {
    relative[c][0] = corner[c][KX] - Float4(ray.origin[KX]);
    relative[c][1] = corner[c][KY] - Float4(ray.origin[KY]);
    relative[c][2] = corner[c][KZ] - Float4(ray.origin[KZ]);
  }
  const EdgeTest<4> test(relative[0], relative[1], relative[2], Float4(ray.shear[0]),
                         Float4(ray.shear[1]), Float4(ray.shear[2]));
  LaneBits lanes = test.hit & ((1u << count) - 1u);
  if (lanes == 0) return;

  Float4 near(-std::numeric_limits<float>::infinity());
  Float4 far(std::numeric_limits<float>::infinity());
  for (int k = 0; k < 3; ++k) {
    const Float4 lo = min(min(corner[0][k], corner[1][k]), corner[2][k]);
    const Float4 hi = max(max(corner[0][k], corner[1][k]), corner[2][k]);
    const bool negative = ray.near_plane[k] != k;
    widen_axis(negative ? hi : lo, negative ? lo : hi, Float4(ray.near_origin[k]),
               Float4(ray.far_origin[k]), Float4(ray.inverse[k]), near, far);
  }
  const Float4 t = max(near, test.t);
  lanes &= (near <= far) & (Float4(local_start(ray)) <= far) & (t <= Float4(limit));
  if (lanes == 0) return;
  alignas(16) float ts[4], us[4], vs[4];
  t.store(ts);
  (test.v / test.det).store(us);
  (test.w / test.det).store(vs);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int i = __builtin_ctz(lanes);
    const float world = world_t(ray, ts[i]);
    const float reported = ray.entry > world ? ray.entry : world;
    if (reported >= ray.t_near) accept(i, reported, us[i], vs[i]);
  }
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
