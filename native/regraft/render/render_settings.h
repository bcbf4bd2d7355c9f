#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>

#include "regraft/shade/camera_rays.h"
#include "regraft/shade/preview_shading.h"

namespace regraft::render {

using shade::Shading;

inline constexpr std::uint32_t max_side = 65536;     ///< pixels
inline constexpr std::uint32_t max_samples = 65536;  ///< a pixel

struct RenderSettings {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  Shading shading = Shading::direct;
  std::uint32_t samples = 1;
  std::uint64_t seed = 0;
  /// Pixels where nothing is seen get alpha 0 instead of the world's colour.
  bool transparent_background = false;
  /// Names as in docs/api.md; unknown ones throw.
  std::set<std::string> passes{"combined"};
  /// Pixels x0, y0, x1, y1 from the lower left corner, half open; all 0: the whole image.
  std::array<std::uint32_t, 4> region{0, 0, 0, 0};
  /// Called on the calling thread about every 20 ms with the finished fraction; returning false
  /// cancels.
  std::function<bool(double)> poll;
};

/// The mode of that name in docs/api.md. Throws std::invalid_argument listing the names.
Shading parse_shading(std::string_view name);
std::string_view name(Shading shading);

/// Each throws std::invalid_argument naming the setting that is wrong.
shade::Raster checked_raster(const RenderSettings& settings);
shade::ShadingSettings checked_shading(const RenderSettings& settings);

}  // namespace regraft::render
