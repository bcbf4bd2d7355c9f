#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "regraft/bvh/restructuring_benefit.h"
#include "regraft/scene/camera.h"

namespace regraft::accel {

/// How trees follow motion: see docs/how-it-works.md.
enum class Policy : std::uint8_t {
  automatic,
  refit,
  rebuild,
  lm,
  rtdeform,
  selective,
  selective_rotate,
  shot
};
enum class Structure : std::uint8_t { automatic, bvh, kdtree };
enum class Layout : std::uint8_t { two_level, flat };

struct UpdateOptions {
  Policy policy = Policy::automatic;
  Structure structure = Structure::automatic;
  Layout layout = Layout::two_level;
  /// Frames of the shot still to come; 0: unknown.
  std::uint32_t frames_left = 0;
  /// From where the scene is going to be looked at, if that is known.
  std::optional<Camera> camera;
  /// What a machine takes for what, in box tests.
  bvh::RestructureConfig costs;
};

enum class TreeUpdate : std::uint8_t { none, refit, restructure, rebuild };

/// What a tree is told when it is updated.
struct Tending {
  Policy policy = Policy::automatic;
  int width = 8;
  /// Rays of the last frame that were likely to reach the tree.
  double rays = 0.0;
  bool traced = false;  ///< trees know what those rays entered
  std::uint32_t frames_left = 0;
  std::uint64_t update = 0;  ///< number of this update
  bvh::RestructureConfig costs;
  /// Nodes and triangles that the last frame's rays visited in the tree; 0: not known.
  double work = 0.0;
};

/// What looking at a tree's damage, and mending it, cost and brought in one update.
struct Look {
  double price = 0.0;  ///< box tests
  double gain = 0.0;   ///< tests of a frame that are saved from now on
};

/// How `auto` has fared with a tree of late.
class Habit {
 public:
  void note(TreeUpdate done, const Look& look);
  /// A tree has worn so much since it was last measured that it is to be looked at.
  void alarm() { is_alarmed_ = true; }
  /// Measuring costs a fifth of a refit, and pays only where something is lost: a tree is measured
  /// as often as what is lost in between comes to what looking costs.
  bool measures() const { return is_alarmed_ || waited_ + 1 >= interval_; }
  /// After five rebuilds in a row only every tenth frame asks whether less would do.
  bool rebuilds_blindly() const { return rebuilds_ >= 5 && frames_ % 10 != 0; }

 private:
  std::uint32_t frames_ = 0;
  std::uint32_t rebuilds_ = 0;  ///< frames in a row in which all was built anew
  std::uint32_t interval_ = 1;  ///< every how many frames a tree is measured
  std::uint32_t waited_ = 0;    ///< frames since it was
  bool is_alarmed_ = false;
};

/// What is known of one tree when its update is chosen.
struct TreeState {
  bool exists = false;
  bool topology_changed = false;
  bool moved = false;
  bool refitted = false;  ///< what follows was measured in this frame
  /// Whether the tests that a rebuild promises to save are worth its cost.
  bool worth_rebuilding = false;
  /// Whether rays have lost as much in the tree since its build as another build costs.
  bool overpaid = false;
  /// Σ A(n)/(A(L)+A(R)) over that just after the build.
  double ratio_change = 1.0;
  Habit habit;
};

/// The one place where refit, restructure or rebuild is decided.
TreeUpdate choose_update(const TreeState& tree, Policy policy);

/// Whether a policy needs the metrics of bvh::LivingBvh in this frame.
bool wants_metrics(Policy policy, const Habit& habit);

std::string_view name(Policy policy);
std::string_view name(Structure structure);
std::string_view name(Layout layout);

}  // namespace regraft::accel
