#pragma once

// Included by each kernels_*.cpp, which is compiled with the flags of its instruction set.

#include "regraft/trace/kernels.h"
#include "regraft/trace/packet.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// W slots a node, R rays a register.
template <int W, int R>
constexpr Kernels kernel_table() {
  return {&Packets<W, R>::closest_hit, &Packets<W, R>::any_hit, &Single<W>::closest_hit,
          &Single<W>::any_hit,         &Single<W>::brute_force, W};
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
