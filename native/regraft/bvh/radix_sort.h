#pragma once

#include <cstdint>

#include "regraft/core/aligned.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// A primitive and the key it is sorted by.
struct KeyedId {
  std::uint32_t id;
  std::uint32_t key;
  friend bool operator==(const KeyedId&, const KeyedId&) = default;
};

/// Sorts by the lowest `bits` of the keys, stably, on all threads; `scratch` is overwritten. O(n).
/// The order of equal keys stays, so the result is the same for any number of threads.
void radix_sort(AlignedVector<KeyedId>& items, AlignedVector<KeyedId>& scratch, int bits,
                Executor& executor);

}  // namespace regraft::bvh
