#pragma once

#include <algorithm>
#include <cstdint>

namespace regraft::accel {

/// When the top of a tree is tried anew: the oftener the better it paid the last time.
class CrownSchedule {
 public:
  /// One more update: whether it is time. `lost`: tests a frame that are there to be won at most.
  bool is_due(double lost, double price) {
    ++waited_;
    return waited_ >= interval_ && lost * waited_ > price;
  }
  /// It was tried, and saved so many tests a frame.
  void note(double saved, double price) {
    const double worth = saved * waited_;
    if (worth > price) interval_ = std::max(interval_ / 2, 1u);
    if (worth < 0.5 * price) interval_ = std::min(interval_ * 2, longest);
    waited_ = 0;
  }

 private:
  /// Updates between two tries where they do not pay.
  static constexpr std::uint32_t longest = 64;
  std::uint32_t interval_ = 2;
  std::uint32_t waited_ = 0;
};

}  // namespace regraft::accel
