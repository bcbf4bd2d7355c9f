#include "regraft/bvh/slot_pool.h"

#include <algorithm>
#include <cassert>

namespace regraft::bvh {

SlotPool::SlotPool(std::vector<std::uint32_t> slots) {
  // From the back, so that the lowest are taken first.
  std::sort(slots.begin(), slots.end(), std::greater<>());
  for (std::size_t i = 0; i < slots.size();) {
    std::size_t j = i + 1;
    while (j < slots.size() && slots[j] + 1 == slots[j - 1]) ++j;
    put({slots[j - 1], std::uint32_t(j - i)});
    i = j;
  }
}

std::uint32_t SlotPool::take(std::uint32_t& count) {
  std::uint32_t length = count;
  while (length <= max_leaf_size && runs_[length].empty()) ++length;
  if (length > max_leaf_size) length = 0;
  if (length == 0 && runs_[0].empty()) {
    for (length = count - 1; runs_[length].empty();) --length;
    assert(length > 0);
    count = length;
  }
  const Run run = runs_[length].back();
  runs_[length].pop_back();
  if (run.count > count) put({run.begin + count, run.count - count});
  return run.begin;
}

}  // namespace regraft::bvh
