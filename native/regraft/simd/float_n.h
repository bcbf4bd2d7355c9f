#pragma once

// Packs of floats. The only place with intrinsics, beside dispatch.cpp.
//
// The same source is compiled several times with different flags; everything lives in a
// namespace named for the instruction set, so that two versions of one inline function never
// meet in the linker. Define REGRAFT_SIMD_SCALAR for the version without intrinsics.

#include <cmath>
#include <cstdint>

#if !defined(REGRAFT_SIMD_SCALAR) && (defined(__SSE2__) || defined(_M_X64))
#include <immintrin.h>
#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
#define REGRAFT_SIMD_NAMESPACE avx512
#elif defined(__AVX2__)
#define REGRAFT_SIMD_NAMESPACE avx2
#elif defined(__SSE4_2__)
#define REGRAFT_SIMD_NAMESPACE sse
#else
#define REGRAFT_SIMD_NAMESPACE sse2
#endif
#else
#define REGRAFT_SIMD_NAMESPACE scalar
#endif

// Loops over lanes grow with every sanitizer's checks; all put into one function they take minutes
// to compile, and nobody waits for them to run fast.
#if defined(REGRAFT_SIMD_SCALAR) && defined(__SANITIZE_ADDRESS__)
#define REGRAFT_INLINE inline
#else
#define REGRAFT_INLINE inline __attribute__((always_inline))
#endif

namespace regraft::simd::REGRAFT_SIMD_NAMESPACE {

/// N truth values, bit i for lane i.
using LaneBits = std::uint32_t;

/// N floats. `min(a, b)` is `a < b ? a : b` and `max(a, b)` is `a > b ? a : b` in each lane: a
/// NaN in `a` is ignored, a NaN in `b` kept, exactly as the hardware has it. Comparisons give
/// lane bits; a comparison with NaN is false.
template <int N>
struct Float {
  float lane[N];

  Float() = default;
  REGRAFT_INLINE Float(float x) {
    for (int i = 0; i < N; ++i) lane[i] = x;
  }
  static REGRAFT_INLINE Float load(const float* p) {
    Float r;
    for (int i = 0; i < N; ++i) r.lane[i] = p[i];
    return r;
  }
  REGRAFT_INLINE void store(float* p) const {
    for (int i = 0; i < N; ++i) p[i] = lane[i];
  }
};

#define REGRAFT_LANEWISE(op)                                                  \
  template <int N>                                                            \
  REGRAFT_INLINE Float<N> operator op(const Float<N>& a, const Float<N>& b) { \
    Float<N> r;                                                               \
    for (int i = 0; i < N; ++i) r.lane[i] = a.lane[i] op b.lane[i];           \
    return r;                                                                 \
  }
REGRAFT_LANEWISE(+)
REGRAFT_LANEWISE(-)
REGRAFT_LANEWISE(*)
REGRAFT_LANEWISE(/)
#undef REGRAFT_LANEWISE

#define REGRAFT_COMPARE(op)                                                   \
  template <int N>                                                            \
  REGRAFT_INLINE LaneBits operator op(const Float<N>& a, const Float<N>& b) { \
    LaneBits r = 0;                                                           \
    for (int i = 0; i < N; ++i) r |= LaneBits(a.lane[i] op b.lane[i]) << i;   \
    return r;                                                                 \
  }
REGRAFT_COMPARE(<)
REGRAFT_COMPARE(<=)
REGRAFT_COMPARE(==)
#undef REGRAFT_COMPARE

template <int N>
REGRAFT_INLINE Float<N> min(const Float<N>& a, const Float<N>& b) {
  Float<N> r;
  for (int i = 0; i < N; ++i) r.lane[i] = a.lane[i] < b.lane[i] ? a.lane[i] : b.lane[i];
  return r;
}
template <int N>
REGRAFT_INLINE Float<N> max(const Float<N>& a, const Float<N>& b) {
  Float<N> r;
  for (int i = 0; i < N; ++i) r.lane[i] = a.lane[i] > b.lane[i] ? a.lane[i] : b.lane[i];
  return r;
}

/// Clears the sign bit, of a NaN too.
template <int N>
REGRAFT_INLINE Float<N> abs(const Float<N>& a) {
  Float<N> r;
  for (int i = 0; i < N; ++i) r.lane[i] = std::fabs(a.lane[i]);
  return r;
}

template <int N>
REGRAFT_INLINE float lowest_lane(const Float<N>& a) {
  alignas(64) float lane[N];
  a.store(lane);
  for (int half = N / 2; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) lane[i] = lane[i + half] < lane[i] ? lane[i + half] : lane[i];
  return lane[0];
}
template <int N>
REGRAFT_INLINE float highest_lane(const Float<N>& a) {
  alignas(64) float lane[N];
  a.store(lane);
  for (int half = N / 2; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) lane[i] = lane[i + half] > lane[i] ? lane[i + half] : lane[i];
  return lane[0];
}

/// Bit i: lane i has the sign bit.
template <int N>
REGRAFT_INLINE LaneBits sign_bits(const Float<N>& a) {
  LaneBits r = 0;
  for (int i = 0; i < N; ++i) r |= LaneBits(std::signbit(a.lane[i])) << i;
  return r;
}

#if defined(__SSE2__) && !defined(REGRAFT_SIMD_SCALAR)
template <>
struct Float<4> {
  __m128 v;
  Float() = default;
  REGRAFT_INLINE Float(__m128 x) : v(x) {}
  REGRAFT_INLINE Float(float x) : v(_mm_set1_ps(x)) {}
  static REGRAFT_INLINE Float load(const float* p) { return _mm_loadu_ps(p); }
  REGRAFT_INLINE void store(float* p) const { _mm_storeu_ps(p, v); }
};
REGRAFT_INLINE Float<4> operator+(Float<4> a, Float<4> b) {
  return _mm_add_ps(a.v, b.v);
}
REGRAFT_INLINE Float<4> operator-(Float<4> a, Float<4> b) {
  return _mm_sub_ps(a.v, b.v);
}
REGRAFT_INLINE Float<4> operator*(Float<4> a, Float<4> b) {
  return _mm_mul_ps(a.v, b.v);
}
REGRAFT_INLINE Float<4> operator/(Float<4> a, Float<4> b) {
  return _mm_div_ps(a.v, b.v);
}
REGRAFT_INLINE LaneBits operator<(Float<4> a, Float<4> b) {
  return LaneBits(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)));
}
REGRAFT_INLINE LaneBits operator<=(Float<4> a, Float<4> b) {
  return LaneBits(_mm_movemask_ps(_mm_cmple_ps(a.v, b.v)));
}
REGRAFT_INLINE LaneBits operator==(Float<4> a, Float<4> b) {
  return LaneBits(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v)));
}
REGRAFT_INLINE LaneBits sign_bits(Float<4> a) {
  return LaneBits(_mm_movemask_ps(a.v));
}
REGRAFT_INLINE Float<4> min(Float<4> a, Float<4> b) {
  return _mm_min_ps(a.v, b.v);
}
REGRAFT_INLINE Float<4> max(Float<4> a, Float<4> b) {
  return _mm_max_ps(a.v, b.v);
}
REGRAFT_INLINE Float<4> abs(Float<4> a) {
  return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v);
}
#endif

#if defined(__AVX2__) && !defined(REGRAFT_SIMD_SCALAR)
template <>
struct Float<8> {
  __m256 v;
  Float() = default;
  REGRAFT_INLINE Float(__m256 x) : v(x) {}
  REGRAFT_INLINE Float(float x) : v(_mm256_set1_ps(x)) {}
  static REGRAFT_INLINE Float load(const float* p) { return _mm256_loadu_ps(p); }
  REGRAFT_INLINE void store(float* p) const { _mm256_storeu_ps(p, v); }
};
REGRAFT_INLINE Float<8> operator+(Float<8> a, Float<8> b) {
  return _mm256_add_ps(a.v, b.v);
}
REGRAFT_INLINE Float<8> operator-(Float<8> a, Float<8> b) {
  return _mm256_sub_ps(a.v, b.v);
}
REGRAFT_INLINE Float<8> operator*(Float<8> a, Float<8> b) {
  return _mm256_mul_ps(a.v, b.v);
}
REGRAFT_INLINE Float<8> operator/(Float<8> a, Float<8> b) {
  return _mm256_div_ps(a.v, b.v);
}
REGRAFT_INLINE LaneBits operator<(Float<8> a, Float<8> b) {
  return LaneBits(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)));
}
REGRAFT_INLINE LaneBits operator<=(Float<8> a, Float<8> b) {
  return LaneBits(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)));
}
REGRAFT_INLINE LaneBits operator==(Float<8> a, Float<8> b) {
  return LaneBits(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)));
}
REGRAFT_INLINE LaneBits sign_bits(Float<8> a) {
  return LaneBits(_mm256_movemask_ps(a.v));
}
REGRAFT_INLINE Float<8> min(Float<8> a, Float<8> b) {
  return _mm256_min_ps(a.v, b.v);
}
REGRAFT_INLINE Float<8> max(Float<8> a, Float<8> b) {
  return _mm256_max_ps(a.v, b.v);
}
REGRAFT_INLINE Float<8> abs(Float<8> a) {
  return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v);
}
#endif

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__) && \
    !defined(REGRAFT_SIMD_SCALAR)
template <>
struct Float<16> {
  __m512 v;
  Float() = default;
  REGRAFT_INLINE Float(__m512 x) : v(x) {}
  REGRAFT_INLINE Float(float x) : v(_mm512_set1_ps(x)) {}
  static REGRAFT_INLINE Float load(const float* p) { return _mm512_loadu_ps(p); }
  REGRAFT_INLINE void store(float* p) const { _mm512_storeu_ps(p, v); }
};
REGRAFT_INLINE Float<16> operator+(Float<16> a, Float<16> b) {
  return _mm512_add_ps(a.v, b.v);
}
REGRAFT_INLINE Float<16> operator-(Float<16> a, Float<16> b) {
  return _mm512_sub_ps(a.v, b.v);
}
REGRAFT_INLINE Float<16> operator*(Float<16> a, Float<16> b) {
  return _mm512_mul_ps(a.v, b.v);
}
REGRAFT_INLINE Float<16> operator/(Float<16> a, Float<16> b) {
  return _mm512_div_ps(a.v, b.v);
}
REGRAFT_INLINE LaneBits operator<(Float<16> a, Float<16> b) {
  return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ);
}
REGRAFT_INLINE LaneBits operator<=(Float<16> a, Float<16> b) {
  return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ);
}
REGRAFT_INLINE LaneBits operator==(Float<16> a, Float<16> b) {
  return _mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ);
}
REGRAFT_INLINE LaneBits sign_bits(Float<16> a) {
  return _mm512_movepi32_mask(_mm512_castps_si512(a.v));
}
REGRAFT_INLINE Float<16> min(Float<16> a, Float<16> b) {
  return _mm512_min_ps(a.v, b.v);
}
REGRAFT_INLINE Float<16> max(Float<16> a, Float<16> b) {
  return _mm512_max_ps(a.v, b.v);
}
REGRAFT_INLINE Float<16> abs(Float<16> a) {
  return _mm512_andnot_ps(_mm512_set1_ps(-0.0f), a.v);
}
#endif

template <int N>
REGRAFT_INLINE LaneBits operator>(const Float<N>& a, const Float<N>& b) {
  return b < a;
}
template <int N>
REGRAFT_INLINE LaneBits operator>=(const Float<N>& a, const Float<N>& b) {
  return b <= a;
}

}  // namespace regraft::simd::REGRAFT_SIMD_NAMESPACE
