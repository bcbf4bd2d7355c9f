#pragma once

#include "regraft/simd/float_n.h"

namespace regraft::simd::REGRAFT_SIMD_NAMESPACE {

/// Four points, structure of arrays.
struct Points4 {
  Float<4> x[3];
};

#if defined(__SSE2__) && !defined(REGRAFT_SIMD_SCALAR)
/// (x, y, z, 0) from three packed floats, reading no byte beyond them.
REGRAFT_INLINE __m128 load3(const float* p) {
  // The integer load is the one that promises no alignment.
  const __m128 xy = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
  return _mm_movelh_ps(xy, _mm_load_ss(p + 2));
}
#endif

/// One point (x, y, z, 0), reading no byte beyond it.
REGRAFT_INLINE Float<4> load_point(const float* p) {
#if defined(__SSE2__) && !defined(REGRAFT_SIMD_SCALAR)
  return load3(p);
#else
  Float<4> r(0.0f);
  for (int k = 0; k < 3; ++k) r.lane[k] = p[k];
  return r;
#endif
}

/// Rows become columns.
REGRAFT_INLINE void transpose(Float<4> (&row)[4]) {
#if defined(__SSE2__) && !defined(REGRAFT_SIMD_SCALAR)
  _MM_TRANSPOSE4_PS(row[0].v, row[1].v, row[2].v, row[3].v);
#else
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < i; ++k) std::swap(row[i].lane[k], row[k].lane[i]);
#endif
}

/// Points `points[3·index[i]]` of a packed x, y, z array.
REGRAFT_INLINE Points4 gather_points(const float* points, const std::uint32_t* index) {
#if defined(__SSE2__) && !defined(REGRAFT_SIMD_SCALAR)
  __m128 a = load3(points + 3 * std::size_t(index[0]));
  __m128 b = load3(points + 3 * std::size_t(index[1]));
  __m128 c = load3(points + 3 * std::size_t(index[2]));
  __m128 d = load3(points + 3 * std::size_t(index[3]));
  _MM_TRANSPOSE4_PS(a, b, c, d);
  return {{Float<4>(a), Float<4>(b), Float<4>(c)}};
#else
  Points4 r;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 4; ++i) r.x[k].lane[i] = points[3 * std::size_t(index[i]) + std::size_t(k)];
  return r;
#endif
}

}  // namespace regraft::simd::REGRAFT_SIMD_NAMESPACE
