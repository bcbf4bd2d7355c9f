#include "regraft/bvh/radix_sort.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace regraft::bvh {

namespace {

/// Counters of one digit fit the first-level cache, and three digits hold a Morton code.
constexpr int digit_bits = 10;
constexpr std::size_t digits = std::size_t(1) << digit_bits;
using Counts = std::array<std::uint32_t, digits>;

/// Fewer than this are sorted by insertion: clearing counters would take longer.
constexpr std::size_t few = 48;

/// Chunks large enough that adding up their counters is nothing, enough of them for many cores.
std::size_t chunk_size(std::size_t count) {
  return std::max<std::size_t>(16384, (count + 63) / 64);
}

std::size_t digit(const KeyedId& item, int shift) {
  return item.key >> shift & (digits - 1);
}

void count(std::span<const KeyedId> items, int shift, Counts& counts) {
  counts.fill(0);
  for (const KeyedId& item : items) ++counts[digit(item, shift)];
}

/// Moves items to where those of their digit are next to go.
void scatter(std::span<const KeyedId> items, int shift, Counts& at, KeyedId* to) {
  for (const KeyedId& item : items) to[at[digit(item, shift)]++] = item;
}

/// Turns the counts of all chunks into the places where their items of each digit begin.
void place(std::span<Counts> counts) {
  std::uint32_t sum = 0;
  for (std::size_t d = 0; d < digits; ++d)
    for (Counts& chunk : counts) {
      const std::uint32_t size = chunk[d];
      chunk[d] = sum;
      sum += size;
    }
}

/// Sorts by one digit from `from` to `to`, on all threads. @return where each digit ends.
Counts sort_digit(std::span<const KeyedId> from, KeyedId* to, int shift, Executor& executor) {
  const std::size_t chunk = chunk_size(from.size());
  std::vector<Counts> counts((from.size() + chunk - 1) / chunk);
  executor.parallel_for(from.size(), chunk, [&](std::size_t begin, std::size_t end) {
    count(from.subspan(begin, end - begin), shift, counts[begin / chunk]);
  });
  place(counts);
  executor.parallel_for(from.size(), chunk, [&](std::size_t begin, std::size_t end) {
    scatter(from.subspan(begin, end - begin), shift, counts[begin / chunk], to);
  });
  return counts.back();
}

void insertion_sort(std::span<KeyedId> items) {
  for (std::size_t i = 1; i < items.size(); ++i) {
    const KeyedId item = items[i];
    std::size_t k = i;
    for (; k > 0 && items[k - 1].key > item.key; --k) items[k] = items[k - 1];
    items[k] = item;
  }
}

/// Sorts a bucket by all digits below its own, the lowest first. Where it is small enough for the
/// second-level cache, memory sees none of that.
void sort_bucket(std::span<KeyedId> items, KeyedId* scratch, int shift, Executor& executor) {
  if (items.size() < few) return insertion_sort(items);
  const std::span<KeyedId> other(scratch, items.size());
  bool is_back = true;
  for (int low = 0; low < shift; low += digit_bits, is_back = !is_back)
    sort_digit(is_back ? items : other, is_back ? scratch : items.data(), low, executor);
  if (!is_back) std::copy(other.begin(), other.end(), items.begin());
}

}  // namespace

void radix_sort(AlignedVector<KeyedId>& items, AlignedVector<KeyedId>& scratch, int bits,
                Executor& executor) {
  scratch.resize(items.size());
  if (items.empty()) return;
  const int shift = std::max(0, (bits - 1) / digit_bits * digit_bits);
  const Counts ends = sort_digit(items, scratch.data(), shift, executor);
  items.swap(scratch);
  const auto sort_of = [&](std::size_t d) {
    const std::size_t begin = d == 0 ? 0 : ends[d - 1];
    sort_bucket({items.data() + begin, ends[d] - begin}, scratch.data() + begin, shift, executor);
  };
  // What holds much of everything is sorted by all threads together, the rest one bucket each.
  const auto is_large = [&](std::size_t d) {
    return ends[d] - (d == 0 ? 0 : ends[d - 1]) > std::max<std::size_t>(65536, items.size() / 8);
  };
  for (std::size_t d = 0; d < digits; ++d)
    if (is_large(d)) sort_of(d);
  executor.parallel_for(digits, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t d = begin; d < end; ++d)
      if (!is_large(d)) sort_of(d);
  });
}

}  // namespace regraft::bvh
