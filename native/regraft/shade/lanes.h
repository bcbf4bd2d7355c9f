#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "regraft/simd/float_n.h"
#include "regraft/trace/hit.h"

namespace regraft::shade {

/// Shading works on one ray packet at a time: a value of 64 pixels is an array, a step of the
/// computation a loop over it. The loops have no branches, so that the compiler turns them into
/// SIMD code; lanes without a ray carry some valid ray's values and are masked out at the end.
inline constexpr std::uint32_t lane_count = trace::packet_capacity;

using LaneMask = std::uint64_t;
inline constexpr LaneMask all_lanes = ~LaneMask(0);

template <typename T>
struct alignas(64) Lanes {
  T value[lane_count];
  constexpr T& operator[](std::size_t i) { return value[i]; }
  constexpr const T& operator[](std::size_t i) const { return value[i]; }
  void fill(T x) {
    for (T& lane : value) lane = x;
  }
};

using FloatLanes = Lanes<float>;
using DoubleLanes = Lanes<double>;

struct Vec3Lanes {
  FloatLanes x, y, z;
};

inline bool has_lane(LaneMask mask, std::uint32_t i) {
  return (mask >> i & 1u) != 0;
}

/// Calls `body(i)` for every set bit, lowest first.
template <typename Body>
void for_each_lane(LaneMask mask, const Body& body) {
  for (; mask != 0; mask &= mask - 1) body(std::uint32_t(std::countr_zero(mask)));
}

/// Bit i is set where `values[i]` < `threshold`.
inline LaneMask lanes_below(const float (&values)[lane_count], float threshold) {
  using Pack = simd::REGRAFT_SIMD_NAMESPACE::Float<4>;
  LaneMask mask = 0;
  for (std::uint32_t i = 0; i < lane_count; i += 4)
    mask |= LaneMask(Pack::load(values + i) < Pack(threshold)) << i;
  return mask;
}

/// Bit i is set where `values[i]` > `threshold`.
inline LaneMask lanes_above(const FloatLanes& values, float threshold) {
  using Pack = simd::REGRAFT_SIMD_NAMESPACE::Float<4>;
  LaneMask mask = 0;
  for (std::uint32_t i = 0; i < lane_count; i += 4)
    mask |= LaneMask(Pack(threshold) < Pack::load(values.value + i)) << i;
  return mask;
}

/// 1 in the lanes of `mask`, 0 elsewhere: what loops multiply by instead of branching.
inline void set_weights(LaneMask mask, FloatLanes& out) {
  // Halves, because 64-bit lanes cannot be compared by every instruction set.
  for (std::uint32_t half = 0; half < lane_count; half += 32) {
    const auto bits = std::uint32_t(mask >> half);
    for (std::uint32_t i = 0; i < 32; ++i) out[half + i] = (bits & 1u << i) != 0 ? 1.0f : 0.0f;
  }
}

inline float max_of(float a, float b) {
  return a > b ? a : b;
}
inline float min_of(float a, float b) {
  return a < b ? a : b;
}

/// Sine and cosine of a full turn's fraction `u` in [0, 1); error below 4e-7. Branch-free,
/// where the library's would stop the loop around it from being vectorised.
inline void sincos_turn(float u, float& sine, float& cosine) {
  // Quarter turns away from the nearest one: |x| ≤ π/4, polynomials of Taylor's series.
  const float quarter = 4.0f * u;
  const int nearest = int(quarter + 0.5f);
  const float x = (quarter - float(nearest)) * 1.57079633f;
  const float q = x * x;
  const float s = x * (1.0f + q * (-1.66666667e-1f + q * (8.33333333e-3f + q * -1.98412698e-4f)));
  const float c =
      1.0f + q * (-0.5f + q * (4.16666667e-2f + q * (-1.38888889e-3f + q * 2.4801587e-5f)));
  const bool swapped = (nearest & 1) != 0;
  const float sine_sign = (nearest & 2) != 0 ? -1.0f : 1.0f;
  const float cosine_sign = ((nearest + 1) & 2) != 0 ? -1.0f : 1.0f;
  sine = sine_sign * (swapped ? c : s);
  cosine = cosine_sign * (swapped ? s : c);
}

/// Two unit vectors that make a right-handed frame with the unit vector n. After Duff et al.,
/// "Building an Orthonormal Basis, Revisited", JCGT 2017, listing 3.
struct Frame3 {
  float tx, ty, tz;
  float bx, by, bz;
  Frame3(float nx, float ny, float nz) {
    const float sign = nz < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + nz);
    const float b = nx * ny * a;
    tx = 1.0f + sign * nx * nx * a, ty = sign * b, tz = -sign * nx;
    bx = b, by = sign + ny * ny * a, bz = -ny;
  }
};

}  // namespace regraft::shade
