#define REGRAFT_SIMD_SCALAR
#include "regraft/trace/kernel_table.h"

namespace regraft::trace {
const Kernels kernels_scalar = scalar::kernel_table<4, 4>();
}
