#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace regraft {

/// The next float below `x`, which is finite; as std::nextafter, but without a call.
inline float next_below(float x) {
  if (x == 0.0f) return -std::numeric_limits<float>::denorm_min();
  const auto bits = std::bit_cast<std::int32_t>(x);
  return std::bit_cast<float>(bits < 0 ? bits + 1 : bits - 1);
}

/// The largest float that is not above `x`.
inline float round_down(double x) {
  const float f = float(x);
  return double(f) > x ? (std::isinf(f) ? std::numeric_limits<float>::max() : next_below(f)) : f;
}

/// The least float that is not below `x`.
inline float round_up(double x) {
  return -round_down(-x);
}

}  // namespace regraft
