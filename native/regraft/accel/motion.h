#pragma once

#include <cstdint>
#include <span>

namespace regraft::accel {

/// Which primitives of a tree may have other boxes than at its last update.
struct Motion {
  /// Any of them: not known which, or too many for them to be told apart.
  bool all = true;
  /// Otherwise these, each once.
  std::span<const std::uint32_t> prims;
};

/// Following single primitives costs about so many times as much for each of them as following all.
inline constexpr std::size_t few_share = 8;

}  // namespace regraft::accel
