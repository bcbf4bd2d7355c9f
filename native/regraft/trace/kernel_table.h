#pragma once

// Included by each kernels_*.cpp, which is compiled with the flags of its instruction set.

#include "regraft/trace/kernels.h"
#include "regraft/trace/packet.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// W slots a node, R rays a register.
template <int W, int R>
constexpr Kernels kernel_table() {
  using Together = Packets<W, R, Going::together>;
  using Apart = Packets<W, R, Going::apart>;
  return {&Together::closest_hit, &Together::any_hit,       &Apart::closest_hit,
          &Apart::any_hit,        &BruteForce::closest_hit, W};
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
