#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "regraft/core/aligned.h"

namespace regraft::kdtree {

/// Memory that is handed out from several threads at once, stays where it is and is given back all
/// together. Takes a lock only when a block is used up.
class NodePool {
 public:
  static constexpr std::size_t block_size = 1 << 18;
  /// Of everything handed out: a pair of nodes is in one cache line.
  static constexpr std::size_t alignment = 32;

  /// Uninitialised.
  void* allocate(std::size_t bytes) {
    bytes = (bytes + alignment - 1) / alignment * alignment;
    for (;;) {
      Block* block = current_.load(std::memory_order_acquire);
      if (block != nullptr) {
        const std::size_t at = block->used.fetch_add(bytes, std::memory_order_relaxed);
        if (at + bytes <= block->data.size()) return block->data.data() + at;
      }
      grow(block, bytes);
    }
  }

  std::size_t bytes() const {
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (const auto& block : blocks_) sum += block->data.size();
    return sum;
  }

 private:
  struct Block {
    AlignedVector<std::byte> data;
    std::atomic<std::size_t> used{0};
  };

  /// Puts a fresh block in the place of `full`, unless another thread has.
  void grow(const Block* full, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (current_.load(std::memory_order_relaxed) != full) return;
    auto block = std::make_unique<Block>();
    // Small trees take small blocks.
    const std::size_t wanted = blocks_.empty() ? block_size / 64 : block_size;
    block->data.resize(bytes > wanted ? bytes : wanted);
    current_.store(block.get(), std::memory_order_release);
    blocks_.push_back(std::move(block));
  }

  std::atomic<Block*> current_{nullptr};
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

}  // namespace regraft::kdtree
