#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace regraft {

/// Memory on a cache-line boundary; for megabytes of it on a boundary of large pages, and the
/// system is asked to use them: trees are walked at random, and thousands of small pages cost
/// more to set up and to look up than what is in them.
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* p, std::size_t bytes);

/// Allocates on cache-line boundaries, so that a pair of tree nodes is one line.
template <typename T>
struct CacheLineAllocator {
  using value_type = T;

  CacheLineAllocator() = default;
  template <typename U>
  CacheLineAllocator(const CacheLineAllocator<U>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(allocate_aligned(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { free_aligned(p, n * sizeof(T)); }
  /// Large scratch arrays of plain data are not filled with zeros first.
  template <typename U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <typename U, typename... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
};

template <typename T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;

}  // namespace regraft
