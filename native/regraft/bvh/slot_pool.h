#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "regraft/bvh/bvh.h"

namespace regraft::bvh {

/// Places in `Bvh::prim_ids` to be shared out to leaves, each of which needs neighbours.
class SlotPool {
 public:
  explicit SlotPool(std::vector<std::uint32_t> slots);

  /// `count` neighbours: the first of them. If there are none, `count` becomes the largest number
  /// that there is.
  std::uint32_t take(std::uint32_t& count);

 private:
  struct Run {
    std::uint32_t begin, count;
  };
  void put(const Run& run) { runs_[run.count <= max_leaf_size ? run.count : 0].push_back(run); }

  /// By length; the longer ones at 0.
  std::array<std::vector<Run>, max_leaf_size + 1> runs_;
};

}  // namespace regraft::bvh
