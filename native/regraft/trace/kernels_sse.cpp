#include "regraft/trace/kernel_table.h"

namespace regraft::trace {
const Kernels kernels_sse = sse::kernel_table<4, 4>();
}
