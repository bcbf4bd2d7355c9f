#pragma once

#include <cstddef>

namespace regraft {

/// `size` elements and a few to spare.
inline std::size_t with_spare(std::size_t size) {
  return size + size / 32;
}

/// Resizes a vector that may hold millions of elements and grows by a few at a time: what it takes
/// beyond them is a small share, where a vector by itself would take as many again.
template <typename Vector, typename... Value>
void grow(Vector& vector, std::size_t size, const Value&... value) {
  if (size > vector.capacity()) vector.reserve(with_spare(size));
  vector.resize(size, value...);
}

}  // namespace regraft
