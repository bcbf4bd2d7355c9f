#pragma once

#include <cstdint>

namespace regraft::test {

/// Packs of `width` floats of one instruction set, as plain functions on arrays: what is compiled
/// for AVX2 is called through a pointer and nowhere else.
struct Lanes {
  int width;
  using Binary = void (*)(const float* a, const float* b, float* result);
  using Compare = std::uint32_t (*)(const float* a, const float* b);
  Binary add, subtract, multiply, divide, min, max;
  Compare less, less_equal, equal, greater, greater_equal;
  void (*broadcast)(float x, float* result);
  std::uint32_t (*sign_bits)(const float* a);
  void (*abs)(const float* a, float* result);
  float (*lowest_lane)(const float* a);
  float (*highest_lane)(const float* a);
};

/// What one instruction set has: packs of 4, 8 and 16, and reads of points.
struct Instructions {
  Lanes lanes[3];
  /// result[k][i] is coordinate k of points[index[i]].
  void (*gather_points)(const float* points, const std::uint32_t* index, float (*result)[4]);
  void (*load_point)(const float* point, float* result);
};

extern const Instructions instructions_scalar;
extern const Instructions instructions_sse;
extern const Instructions instructions_avx2;
extern const Instructions instructions_avx512;

}  // namespace regraft::test
