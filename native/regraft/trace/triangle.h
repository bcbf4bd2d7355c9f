#pragma once

#include <cmath>
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

/// Watertight test (Woop, Benthin, Wald, JCGT 2013): edge functions, determinant and distance of N
/// (ray, triangle) pairs. Corners are given relative to the ray's origin, sheared axes first.
/// Needs `-ffp-contract=off`: fused edge functions open cracks.
///
/// Signs are always those of the exact edge functions of the sheared corners: rounding is
/// monotone, and what it makes 0, or not a number, is computed again in double. So neighbours
/// agree on their common edge.
template <int N>
struct EdgeTest {
  Float<N> u, v, w, det, t;
  LaneBits hit;

  /// `too_early(t)`: lanes in which a hit at or before t is none, whatever else is known. Spares
  /// rays that start on a surface the way to a precise hit on that surface.
  template <typename TooEarly>
  REGRAFT_INLINE EdgeTest(const Float<N> (&a)[3], const Float<N> (&b)[3], const Float<N> (&c)[3],
                          Float<N> sx, Float<N> sy, Float<N> sz, const TooEarly& too_early) {
    const Float<N> x[3] = {a[0] - sx * a[2], b[0] - sx * b[2], c[0] - sx * c[2]};
    const Float<N> y[3] = {a[1] - sy * a[2], b[1] - sy * b[2], c[1] - sy * c[2]};
    const Float<N> z[3] = {a[2], b[2], c[2]};
    u = x[2] * y[1] - y[2] * x[1];
    v = x[0] * y[2] - y[0] * x[2];
    w = x[1] * y[0] - y[1] * x[0];
    det = (u + v) + w;
    const Float<N> zero(0.0f);
    // The determinant comes last: a NaN among the others makes it one, and is kept only there.
    const Float<N> least = min(min(min(abs(u), abs(v)), abs(w)), abs(det));
    const LaneBits doubtful = ~(zero < least) & all;
    if (doubtful != 0) redo_signs(x, y, doubtful);
    const Float<N> lowest = min(min(u, v), w), highest = max(max(u, v), w);
    hit = ~((lowest < zero) & (zero < highest)) & (zero < abs(det));
    if (hit == 0) return;
    t = (((u * z[0] + v * z[1]) + w * z[2]) / det) * sz;
    const Conditioning conditioning(x, y, z, abs(det));
    hit &= ~too_early(t + conditioning.error * abs(sz)) | doubtful;
    const LaneBits rough = hit & (doubtful | conditioning.ill);
    if (rough != 0) redo_point(x, y, z, sz, rough);
  }

 private:
  static constexpr LaneBits all = LaneBits((std::uint64_t(1) << N) - 1);

  /// The edge functions in double, where each product of two floats is exact.
  struct Exact {
    double u, v, w;
    REGRAFT_INLINE Exact(const float (&x)[3][N], const float (&y)[3][N], int i)
        : u(double(x[2][i]) * y[1][i] - double(y[2][i]) * x[1][i]),
          v(double(x[0][i]) * y[2][i] - double(y[0][i]) * x[2][i]),
          w(double(x[1][i]) * y[0][i] - double(y[1][i]) * x[0][i]) {}
  };

  static REGRAFT_INLINE void store(const Float<N> (&from)[3], float (&to)[3][N]) {
    for (int k = 0; k < 3; ++k) from[k].store(to[k]);
  }

  /// Scaled to magnitudes about 1, so that no sign is lost to the range of floats.
  REGRAFT_INLINE void redo_signs(const Float<N> (&x)[3], const Float<N> (&y)[3], LaneBits lanes) {
    alignas(64) float px[3][N], py[3][N], e[3][N];
    store(x, px), store(y, py);
    u.store(e[0]), v.store(e[1]), w.store(e[2]);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int i = __builtin_ctz(lanes);
      const Exact exact(px, py, i);
      const double largest = largest_of(std::fabs(exact.u), std::fabs(exact.v), std::fabs(exact.w));
      const double scale = largest > 0.0 ? 1.0 / largest : 1.0;
      e[0][i] = float(exact.u * scale);
      e[1][i] = float(exact.v * scale);
      e[2][i] = float(exact.w * scale);
    }
    u = Float<N>::load(e[0]), v = Float<N>::load(e[1]), w = Float<N>::load(e[2]);
    det = (u + v) + w;
  }

  static REGRAFT_INLINE double largest_of(double a, double b, double c) {
    const double ab = a > b ? a : b;
    return ab > c ? ab : c;
  }

  /// What cancellation in the edge functions does to hits: there the corners surround the ray,
  /// and extents bound their coordinates.
  struct Conditioning {
    LaneBits ill;    ///< moved by more than 2^-20 of the distance, or out of the range of floats
    Float<N> error;  ///< more than the error of `t` can be, before it is scaled

    REGRAFT_INLINE Conditioning(const Float<N> (&x)[3], const Float<N> (&y)[3],
                                const Float<N> (&z)[3], Float<N> size) {
      const auto lowest = [](const Float<N>(&p)[3]) { return min(min(p[0], p[1]), p[2]); };
      const auto highest = [](const Float<N>(&p)[3]) { return max(max(p[0], p[1]), p[2]); };
      const Float<N> z_lo = lowest(z), z_hi = highest(z);
      const Float<N> distance = max(z_hi, Float<N>(0.0f) - z_lo);
      const Float<N> noise = ((highest(x) - lowest(x)) * (highest(y) - lowest(y))) * (z_hi - z_lo);
      const Float<N> least(0x1p-100f);
      ill = ~(noise + least < size * distance);
      error =
          Float<N>(0x1p-18f) * ((noise + least * (distance + Float<N>(1.0f))) / size + distance);
    }
  };

  /// u, v, w as weights (their sum, `det`, is 1 then) and t, in double.
  REGRAFT_INLINE void redo_point(const Float<N> (&x)[3], const Float<N> (&y)[3],
                                 const Float<N> (&z)[3], Float<N> sz, LaneBits lanes) {
    alignas(64) float px[3][N], py[3][N], pz[3][N], scale[N], e[5][N];
    store(x, px), store(y, py), store(z, pz), sz.store(scale);
    u.store(e[0]), v.store(e[1]), w.store(e[2]), det.store(e[3]), t.store(e[4]);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int i = __builtin_ctz(lanes);
      const Exact exact(px, py, i);
      const double sum = (exact.u + exact.v) + exact.w;
      e[0][i] = float(exact.u / sum);
      e[1][i] = float(exact.v / sum);
      e[2][i] = float(exact.w / sum);
      e[3][i] = 1.0f;
      const double depth = (exact.u * pz[0][i] + exact.v * pz[1][i]) + exact.w * pz[2][i];
      e[4][i] = float(depth / sum * scale[i]);
    }
    u = Float<N>::load(e[0]), v = Float<N>::load(e[1]), w = Float<N>::load(e[2]);
    det = Float<N>::load(e[3]), t = Float<N>::load(e[4]);
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

/// True for a triangle that a refitted tree still holds although its area has become zero.
/// Rounding may find a hit on it; a tree built anew would not have it.
REGRAFT_INLINE bool lacks_area(const MeshView& mesh, std::uint32_t prim) {
  return mesh.refitted && !has_area(mesh, prim);
}

/// Four triangles side by side.
struct Corners4 {
  Float4 corner[3][3];  ///< by corner, by axis
};

/// Corners of `count` (1–4) triangles; lanes beyond repeat the first.
REGRAFT_INLINE Corners4 gather_corners(const MeshView& mesh, const std::uint32_t* prims,
                                       int count) {
  std::uint32_t index[3][4];
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t* corners = mesh.triangles + 3 * std::size_t(prims[i < count ? i : 0]);
    for (int c = 0; c < 3; ++c) index[c][i] = corners[c];
  }
  Corners4 r;
  for (int c = 0; c < 3; ++c) {
    const auto p = simd::REGRAFT_SIMD_NAMESPACE::gather_points(mesh.vertices, index[c]);
    for (int k = 0; k < 3; ++k) r.corner[c][k] = p.x[k];
  }
  return r;
}

/// Tests `count` (1–4) triangles of a mesh against a ray; for each hit calls
/// `accept(lane, world_t, u, v)` in lane order.
///
/// t is clamped to the triangle's own box: what the tree compares against box intervals then
/// never lies outside the box of any ancestor, whatever the rounding, so no order of traversal
/// and no interval that ends at the hit can hide it.
template <int KZ, typename Accept>
REGRAFT_INLINE void test_triangles(const LocalRay& ray, const MeshView& mesh,
                                   const Corners4& corners, const std::uint32_t* prims, int count,
                                   float limit, const Accept& accept) {
  constexpr int KX = (KZ + 1) % 3;
  constexpr int KY = (KZ + 2) % 3;
  const Float4(&corner)[3][3] = corners.corner;
  Float4 relative[3][3];
  for (int c = 0; c < 3; ++c) {
    relative[c][0] = corner[c][KX] - Float4(ray.origin[KX]);
    relative[c][1] = corner[c][KY] - Float4(ray.origin[KY]);
    relative[c][2] = corner[c][KZ] - Float4(ray.origin[KZ]);
  }
  // A hit before the instance's box begins is reported where it begins.
  const bool starts_inside = ray.entry < ray.t_near;
  const EdgeTest<4> test(relative[0], relative[1], relative[2], Float4(ray.shear[0]),
                         Float4(ray.shear[1]), Float4(ray.shear[2]), [&](const Float4& latest) {
                           return starts_inside ? latest < Float4(local_start(ray)) : LaneBits(0);
                         });
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
  const Float4 t = min(far, max(near, test.t));
  lanes &= (near <= far) & (Float4(local_start(ray)) <= far) & (t <= Float4(limit));
  if (lanes == 0) return;
  alignas(16) float ts[4], us[4], vs[4];
  t.store(ts);
  (test.v / test.det).store(us);
  (test.w / test.det).store(vs);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int i = __builtin_ctz(lanes);
    const float reported = world_t(ray, ts[i]);
    // Beyond the range of floats there is nothing: t = inf says that nothing was hit.
    if (!std::isfinite(reported) || reported < ray.t_near || lacks_area(mesh, prims[i])) continue;
    accept(i, reported, us[i], vs[i]);
  }
}

/// The same with the corners gathered first.
template <int KZ, typename Accept>
REGRAFT_INLINE void test_triangles(const LocalRay& ray, const MeshView& mesh,
                                   const std::uint32_t* prims, int count, float limit,
                                   const Accept& accept) {
  test_triangles<KZ>(ray, mesh, gather_corners(mesh, prims, count), prims, count, limit, accept);
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
