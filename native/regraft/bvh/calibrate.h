#pragma once

#include <cstddef>
#include <functional>

#include "regraft/core/executor.h"

namespace regraft::bvh {

/// What operations cost on this machine, in units of one ray/box test (Yoon, Curtis, Manocha 2007,
/// section 4): of one ray/triangle test, of a build divided by m·log2(m), of looking at one pair,
/// of a build along a Morton curve divided by m.
/// The defaults are what tests use everywhere.
struct MachineConstants {
  double leaf = 1.5;
  double rebuild = 10.0;
  double refine = 4.0;
  double morton = 10.0;
};

/// What is timed; each call does the work once and returns how many operations that was.
struct Probes {
  std::function<std::size_t()> box_tests;
  std::function<std::size_t()> triangle_tests;
  std::function<std::size_t()> pairs;
};

/// Probes of our own for the two tests: the slab test of a binary traversal and a watertight test,
/// four at once as the kernels do them, over boxes and triangles that fit the second-level cache.
Probes test_probes();

/// Times the probes and builds over 2^10 to 2^16 primitives, each the median of nine runs; rebuild
/// is the least-squares slope of time over m·log2(m). Without `probes.pairs` refine keeps its
/// default. Takes about a second; the executor should be that of the updates.
MachineConstants calibrate(const Probes& probes, Executor& executor);

}  // namespace regraft::bvh
