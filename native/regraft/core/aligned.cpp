#include "regraft/core/aligned.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace regraft {

namespace {

constexpr std::size_t cache_line = 64;
constexpr std::size_t large_page = std::size_t(1) << 21;
/// Below this the rounding to large pages would waste too much.
constexpr std::size_t large = 2 * large_page;

std::align_val_t alignment(std::size_t bytes) {
  return std::align_val_t(bytes < large ? cache_line : large_page);
}

}  // namespace

void* allocate_aligned(std::size_t bytes) {
  void* p = ::operator new(bytes, alignment(bytes));
#if defined(__linux__)
  // Only a hint; memory is memory without it.
  if (bytes >= large) static_cast<void>(madvise(p, bytes / large_page * large_page, MADV_HUGEPAGE));
#endif
  return p;
}

void free_aligned(void* p, std::size_t bytes) {
  ::operator delete(p, alignment(bytes));
}

}  // namespace regraft
