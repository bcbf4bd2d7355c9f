#include "simd/lanes_table.h"

namespace regraft::test {
const Instructions instructions_avx2 = avx2::instructions();
}
