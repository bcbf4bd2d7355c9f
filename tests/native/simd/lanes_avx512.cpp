#include "simd/lanes_table.h"

namespace regraft::test {
const Instructions instructions_avx512 = avx512::instructions();
}
