#include "regraft/shade/heat_map.h"

#include <algorithm>
#include <cmath>

namespace regraft::shade {

namespace {

/// "inferno" of matplotlib (public domain) at even steps, linear RGB; straight lines between
/// these stay within 0.03 of it.
constexpr float inferno[17][3] = {
    {0.0001f, 0.0000f, 0.0011f}, {0.0033f, 0.0022f, 0.0176f}, {0.0152f, 0.0037f, 0.0688f},
    {0.0463f, 0.0028f, 0.1303f}, {0.0955f, 0.0051f, 0.1544f}, {0.1636f, 0.0099f, 0.1561f},
    {0.2539f, 0.0163f, 0.1437f}, {0.3674f, 0.0249f, 0.1200f}, {0.5005f, 0.0383f, 0.0891f},
    {0.6336f, 0.0597f, 0.0594f}, {0.7684f, 0.0993f, 0.0326f}, {0.8779f, 0.1648f, 0.0135f},
    {0.9487f, 0.2642f, 0.0030f}, {0.9728f, 0.4034f, 0.0047f}, {0.9465f, 0.5870f, 0.0319f},
    {0.8872f, 0.8083f, 0.1296f}, {0.9737f, 0.9963f, 0.3735f}};

}  // namespace

Vec3 heat_color(float cost) {
  const float share = std::log2(1.0f + std::max(cost, 0.0f)) / std::log2(1.0f + heat_map_top);
  const float place = 16.0f * std::min(share, 1.0f);
  const int below = std::min(int(place), 15);
  const float part = place - float(below);
  Vec3 color;
  for (int k = 0; k < 3; ++k)
    color[k] = inferno[below][k] + part * (inferno[below + 1][k] - inferno[below][k]);
  return color;
}

}  // namespace regraft::shade
