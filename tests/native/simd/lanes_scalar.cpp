#define REGRAFT_SIMD_SCALAR
#include "simd/lanes_table.h"

namespace regraft::test {
const Instructions instructions_scalar = scalar::instructions();
}
