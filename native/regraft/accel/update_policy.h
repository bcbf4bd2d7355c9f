#pragma once

#include <cstdint>
#include <string_view>

namespace regraft::accel {

enum class Policy : std::uint8_t { automatic, refit, rebuild };
enum class Structure : std::uint8_t { automatic, bvh };
enum class Layout : std::uint8_t { two_level, flat };

struct UpdateOptions {
  Policy policy = Policy::automatic;
  Structure structure = Structure::automatic;
  Layout layout = Layout::two_level;
  /// Frames of the shot still to come; 0: unknown.
  std::uint32_t frames_left = 0;
};

enum class TreeUpdate : std::uint8_t { none, refit, rebuild };

/// `auto` rebuilds a tree whose wear (bvh::RefitResult) has grown to this since its last build:
/// about where a frame's extra tests cost as much as the build that would save them.
inline constexpr double worn_out = 1.3;

/// What is known of one tree when its update is chosen.
struct TreeState {
  bool exists = false;
  bool topology_changed = false;
  bool moved = false;
  /// How much worse it has become since its last build; see bvh::RefitResult.
  double wear = 1.0;
};

/// The one place where refit or rebuild is decided.
TreeUpdate choose_update(const TreeState& tree, Policy policy);

std::string_view name(Policy policy);
std::string_view name(Layout layout);

}  // namespace regraft::accel
