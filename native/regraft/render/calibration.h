#pragma once

#include "regraft/bvh/calibrate.h"
#include "regraft/core/executor.h"
#include "regraft/simd/dispatch.h"

namespace regraft::render {

/// What operations cost on this machine in units of what C(root) counts: one expected test of a
/// ray, as rays really take it. Builds and rays are timed on all threads of the executor. Takes a
/// few seconds; meaningless while the machine does something else.
bvh::MachineConstants calibrate(Executor& executor, simd::Isa isa);

}  // namespace regraft::render
