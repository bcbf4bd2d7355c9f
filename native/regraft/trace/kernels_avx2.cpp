#include "regraft/trace/kernel_table.h"

namespace regraft::trace {
const Kernels kernels_avx2 = avx2::kernel_table<8, 8>();
}
