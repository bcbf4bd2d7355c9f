#pragma once

#include "regraft/bvh/calibrate.h"

namespace regraft::bindings {

using MachineCosts = bvh::MachineConstants;

/// Those of all scenes of the process; read and written while holding the GIL.
MachineCosts& machine_costs();

}  // namespace regraft::bindings
