#pragma once

#include <algorithm>

namespace regraft::accel {

/// Adds up what rays lose in a tree. Areas speak of lines from anywhere; a camera may look at
/// nothing but the damage. Once what rays did beyond what they did just after the last build has
/// cost as much as another build, one is due, so that both together never cost more than twice what
/// the best moment would have. If builds turn out not to bring it back, since the scene or the view
/// is another, it takes so much longer until the next is due.
class RayLedger {
 public:
  /// A frame's rays visited so many nodes and triangles in the tree; 0: not known.
  void note(double work) {
    if (!(work > 0.0)) return;
    if (at_first_ == 0.0) {
      if (lost_ > noise * last_)
        yield_ = std::clamp(0.5 * yield_ + 0.5 * (last_ - work) / lost_, least_yield, 1.0);
      at_first_ = work;
    }
    last_ = work;
    beyond_ += std::max(0.0, work - at_first_);
  }
  /// The tree has been built anew.
  void begin() {
    lost_ = last_ - at_first_;
    at_first_ = beyond_ = 0.0;
  }
  /// Box tests that were lost since, as far as builds are known to bring them back.
  double lost_tests() const { return visit_cost * yield_ * beyond_; }

 private:
  /// Box tests of the cost model that visiting a wide node, or testing a triangle, costs: 30 ns
  /// where the model's unit, by what builds take, is 3.8.
  static constexpr double visit_cost = 8.0;
  /// Less than this share of the work is no loss to learn from.
  static constexpr double noise = 0.05;
  static constexpr double least_yield = 0.02;

  double at_first_ = 0.0;  ///< a frame just after the build
  double last_ = 0.0;
  double beyond_ = 0.0;  ///< the sum of what later frames did beyond that
  double lost_ = 0.0;    ///< what the last frame before the build did beyond the first
  double yield_ = 1.0;
};

}  // namespace regraft::accel
