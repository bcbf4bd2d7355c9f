#pragma once

#include <algorithm>
#include <cstdint>

namespace regraft::accel {

/// How long rays have kept away from a mesh. One that they have not met for some frames is likely
/// not to be met in the next, so its tree may wait. Waiting in vain costs little, but the update is
/// then one thread's work: a mesh at the edge of the view is left behind ever more rarely.
class Absence {
 public:
  /// Whether a frame's rays met the mesh.
  void note(bool is_met) { frames_ = is_met ? 0 : frames_ + 1; }
  /// Rays came near after all while its tree was behind.
  void end() {
    const bool has_paid = frames_ > 2 * patience_;
    patience_ = has_paid ? least_patience : std::min(2 * patience_, most_patience);
    frames_ = 0;
  }
  bool is_lasting() const { return frames_ >= patience_; }

 private:
  static constexpr std::uint32_t least_patience = 2;
  static constexpr std::uint32_t most_patience = 32;

  std::uint32_t frames_ = 0;
  std::uint32_t patience_ = least_patience;
};

}  // namespace regraft::accel
