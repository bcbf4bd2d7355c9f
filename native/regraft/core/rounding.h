#pragma once

#include <cmath>
#include <limits>

namespace regraft {

/// The largest float that is not above `x`.
inline float round_down(double x) {
  const float f = float(x);
  return double(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

/// The least float that is not below `x`.
inline float round_up(double x) {
  const float f = float(x);
  return double(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace regraft
