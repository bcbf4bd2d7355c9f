#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "regraft/core/aabb.h"

namespace regraft::accel {

/// Nodes of all trees, to be drawn or counted.
struct NodeBatch {
  /// World boxes in double: lowest and highest corner.
  std::vector<std::array<double, 6>> boxes;
  /// Excess cost of each as a share of what it costs, E/(C·A); 0 where nothing is measured.
  std::vector<double> damage;
  /// Made anew by the last update that changed the scene, or holding nodes that were.
  std::vector<std::uint8_t> rebuilt;
};

}  // namespace regraft::accel
