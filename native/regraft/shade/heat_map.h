#pragma once

#include "regraft/core/vec.h"

namespace regraft::shade {

/// Cost shown at the map's bright end; the scale is logarithmic and the same for every picture,
/// so that frames can be compared.
inline constexpr float heat_map_top = 4096.0f;

/// Linear RGB of a cost (nodes visited plus triangles tested): log2(1 + cost) / log2(1 + top)
/// looked up in "inferno", whose lightness rises evenly from black to pale yellow.
Vec3 heat_color(float cost);

}  // namespace regraft::shade
