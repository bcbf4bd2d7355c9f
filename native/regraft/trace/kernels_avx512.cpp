#include "regraft/trace/kernel_table.h"

namespace regraft::trace {
const Kernels kernels_avx512 = avx512::kernel_table<8, 16>();
}
