#include "regraft/bvh/radix_sort.h"

#include <algorithm>
#include <array>
#include <vector>

namespace regraft::bvh {

namespace {

/// Counters of one digit fit the first-level cache, and three digits hold a Morton code.
constexpr int digit_bits = 10;
constexpr std::size_t digits = std::size_t(1) << digit_bits;
using Counts = std::array<std::uint32_t, digits>;

/// Chunks large enough that adding up their counters is nothing, enough of them for many cores.
std::size_t chunk_size(std::size_t count) {
  return std::max<std::size_t>(16384, (count + 63) / 64);
}

std::size_t digit(const KeyedId& item, int shift) {
  return item.key >> shift & (digits - 1);
}

/// Turns the counts of all chunks into the places where their items of each digit begin.
void place(std::vector<Counts>& counts) {
  std::uint32_t sum = 0;
  for (std::size_t d = 0; d < digits; ++d)
    for (Counts& chunk : counts) {
      const std::uint32_t count = chunk[d];
      chunk[d] = sum;
      sum += count;
    }
}

}  // namespace

void radix_sort(AlignedVector<KeyedId>& items, AlignedVector<KeyedId>& scratch, int bits,
                Executor& executor) {
  scratch.resize(items.size());
  const std::size_t chunk = chunk_size(items.size());
  std::vector<Counts> counts((items.size() + chunk - 1) / chunk);
  for (int shift = 0; shift < bits; shift += digit_bits) {
    executor.parallel_for(items.size(), chunk, [&](std::size_t begin, std::size_t end) {
      Counts& count = counts[begin / chunk];
      count.fill(0);
      for (std::size_t i = begin; i < end; ++i) ++count[digit(items[i], shift)];
    });
    place(counts);
    executor.parallel_for(items.size(), chunk, [&](std::size_t begin, std::size_t end) {
      Counts& at = counts[begin / chunk];
      for (std::size_t i = begin; i < end; ++i) scratch[at[digit(items[i], shift)]++] = items[i];
    });
    items.swap(scratch);
  }
}

}  // namespace regraft::bvh
