#include "regraft/trace/late_tree.h"

namespace regraft::trace {

LateTree::~LateTree() = default;

void LateTree::arrive() {
  std::uint32_t state = state_.load(std::memory_order_acquire);
  while (state != ready) {
    if (state == catching_up) {
      state_.wait(catching_up, std::memory_order_acquire);
      state = state_.load(std::memory_order_acquire);
    } else if (state_.compare_exchange_weak(state, catching_up, std::memory_order_acquire)) {
      try {
        catch_up();
      } catch (...) {
        leave(behind);
        throw;
      }
      return leave(ready);
    }
  }
}

bool LateTree::has_arrived() const {
  return state_.load(std::memory_order_acquire) == ready;
}

void LateTree::leave(State state) {
  state_.store(state, std::memory_order_release);
  state_.notify_all();
}

}  // namespace regraft::trace
