#pragma once

#include <algorithm>
#include <cstdint>

namespace regraft::accel {

/// What mending may cost in one update, in box tests, so that no frame takes much longer than the
/// one before: a share of what following the motion costs anyway. What is left over waits for the
/// next update.
class MendingBudget {
 public:
  void note_refit(std::uint64_t nodes) {
    const double cost = refit_cost * double(nodes);
    // A tree of which only a part moves is refitted as a whole once: that is not what is usual.
    const bool is_new = usual_ == 0.0 || usual_ > 2.0 * cost;
    usual_ = is_new ? cost : usual_ + 0.25 * (cost - usual_);
  }
  double tests() const { return std::max(share * usual_, least); }
  /// How many things may be looked at in half of that, if each costs `price`.
  std::uint32_t looks(double price) const {
    return std::uint32_t(std::clamp(0.5 * tests() / price, 64.0, 1e6));
  }

 private:
  /// Refitting and measuring a node.
  static constexpr double refit_cost = 6.0;
  static constexpr double share = 0.4;
  /// A few hundred microseconds are nobody's hitch.
  static constexpr double least = 32768.0;
  double usual_ = 0.0;
};

}  // namespace regraft::accel
