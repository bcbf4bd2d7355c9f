#pragma once

// Included by each lanes_*.cpp, which is compiled with the flags of its instruction set.

#include "regraft/simd/gather.h"
#include "simd/lanes.h"

namespace regraft::test::REGRAFT_SIMD_NAMESPACE {

namespace simd = regraft::simd::REGRAFT_SIMD_NAMESPACE;

template <int N>
struct Ops {
  using F = simd::Float<N>;
  static F get(const float* p) { return F::load(p); }
  static void add(const float* a, const float* b, float* r) { (get(a) + get(b)).store(r); }
  static void subtract(const float* a, const float* b, float* r) { (get(a) - get(b)).store(r); }
  static void multiply(const float* a, const float* b, float* r) { (get(a) * get(b)).store(r); }
  static void divide(const float* a, const float* b, float* r) { (get(a) / get(b)).store(r); }
  static void least(const float* a, const float* b, float* r) { min(get(a), get(b)).store(r); }
  static void most(const float* a, const float* b, float* r) { max(get(a), get(b)).store(r); }
  static std::uint32_t less(const float* a, const float* b) { return get(a) < get(b); }
  static std::uint32_t less_equal(const float* a, const float* b) { return get(a) <= get(b); }
  static std::uint32_t equal(const float* a, const float* b) { return get(a) == get(b); }
  static std::uint32_t greater(const float* a, const float* b) { return get(a) > get(b); }
  static std::uint32_t greater_equal(const float* a, const float* b) { return get(a) >= get(b); }
  static void broadcast(float x, float* r) { F(x).store(r); }
  static std::uint32_t signs(const float* a) { return sign_bits(get(a)); }
  static void size(const float* a, float* r) { abs(get(a)).store(r); }
  static float lowest(const float* a) { return lowest_lane(get(a)); }
  static float highest(const float* a) { return highest_lane(get(a)); }

  static constexpr Lanes table() {
    return {N,     add,     subtract,      multiply,  divide, least, most,   less,   less_equal,
            equal, greater, greater_equal, broadcast, signs,  size,  lowest, highest};
  }
};

inline void gather(const float* points, const std::uint32_t* index, float (*result)[4]) {
  const auto p = simd::gather_points(points, index);
  for (int k = 0; k < 3; ++k) p.x[k].store(result[k]);
}

inline void load(const float* point, float* result) {
  simd::load_point(point).store(result);
}

constexpr Instructions instructions() {
  return {{Ops<4>::table(), Ops<8>::table(), Ops<16>::table()}, gather, load};
}

}  // namespace regraft::test::REGRAFT_SIMD_NAMESPACE
