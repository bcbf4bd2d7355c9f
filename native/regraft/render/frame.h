#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "regraft/accel/update_statistics.h"
#include "regraft/shade/image.h"

namespace regraft::render {

/// What one render cost; names as in docs/statistics.md.
struct FrameStatistics : accel::UpdateStatistics {
  double evaluate_ms = 0.0;
  double extract_ms = 0.0;
  double trace_ms = 0.0;
  double shade_ms = 0.0;
  double write_ms = 0.0;
  std::int64_t frame = 0;
  std::uint64_t rays_primary = 0;
  std::uint64_t rays_shadow = 0;
  std::uint64_t rays_secondary = 0;
  std::uint64_t nodes_visited = 0;
  std::uint64_t triangle_tests = 0;
  double observed_cost = 0.0;

  double total_ms() const {
    return evaluate_ms + extract_ms + update_ms + trace_ms + shade_ms + write_ms;
  }
};

struct Frame {
  std::map<std::string, shade::Image> passes;
  FrameStatistics statistics;
  bool cancelled = false;
};

}  // namespace regraft::render
