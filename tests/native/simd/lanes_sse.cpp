#include "simd/lanes_table.h"

namespace regraft::test {
const Instructions instructions_sse = sse::instructions();
}
