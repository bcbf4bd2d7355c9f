#include "regraft/core/aligned.h"

#include <algorithm>
#include <array>
#include <bit>
#include <mutex>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace regraft {

namespace {

constexpr std::align_val_t cache_line{64};
constexpr std::size_t large_page = std::size_t(1) << 21;
/// Below this the rounding to large pages would waste too much.
constexpr std::size_t large = 2 * large_page;

/// What is really allocated for `bytes`: whole large pages, in steps of at most an eighth, so that
/// what a tree of about the same size needs in the next frame is the same.
std::size_t block_size(std::size_t bytes) {
  const std::size_t step = std::max(large_page, std::bit_floor(bytes) / 8);
  return (bytes + step - 1) / step * step;
}

void* new_block(std::size_t size) {
  void* p = ::operator new(size, std::align_val_t(large_page));
#if defined(__linux__)
  // Only a hint; memory is memory without it.
  static_cast<void>(madvise(p, size, MADV_HUGEPAGE));
#endif
  return p;
}

void delete_block(void* p) {
  ::operator delete(p, std::align_val_t(large_page));
}

/// Large blocks that were given back wait here for the next tree: of a new one the system has to
/// clear every page first, a quarter of the time of a fast build. Never more waits than is in use,
/// so that what a scene needed goes with the scene.
class SpareBlocks {
 public:
  void* allocate(std::size_t size) {
    void* p = take(size);
    return p != nullptr ? p : new_block(size);
  }

  void free(void* p, std::size_t size) {
    const std::lock_guard lock(mutex_);
    in_use_ -= size;
    if (count_ == spare_.size()) drop_oldest();
    spare_[count_++] = {p, size};
    waiting_ += size;
    while (waiting_ > in_use_) drop_oldest();
  }

 private:
  struct Block {
    void* p;
    std::size_t size;
  };

  void* take(std::size_t size) {
    const std::lock_guard lock(mutex_);
    in_use_ += size;
    for (std::size_t i = count_; i-- > 0;) {
      if (spare_[i].size != size) continue;
      void* p = spare_[i].p;
      remove(i);
      return p;
    }
    return nullptr;
  }

  void drop_oldest() {
    delete_block(spare_[0].p);
    remove(0);
  }

  void remove(std::size_t i) {
    waiting_ -= spare_[i].size;
    std::copy(spare_.begin() + std::ptrdiff_t(i) + 1, spare_.begin() + std::ptrdiff_t(count_),
              spare_.begin() + std::ptrdiff_t(i));
    --count_;
  }

  std::mutex mutex_;
  std::array<Block, 64> spare_;  ///< `count_` of them, the oldest first
  std::size_t count_ = 0;
  std::size_t in_use_ = 0;
  std::size_t waiting_ = 0;
};

/// Never destroyed: memory may be given back later than any static object.
SpareBlocks& spare_blocks() {
  static SpareBlocks& blocks = *new SpareBlocks;
  return blocks;
}

}  // namespace

void* allocate_aligned(std::size_t bytes) {
  return bytes < large ? ::operator new(bytes, cache_line)
                       : spare_blocks().allocate(block_size(bytes));
}

void free_aligned(void* p, std::size_t bytes) {
  if (bytes < large)
    ::operator delete(p, cache_line);
  else
    spare_blocks().free(p, block_size(bytes));
}

}  // namespace regraft
