#include "regraft/render/render_settings.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace regraft::render {

namespace {

constexpr std::pair<std::string_view, Shading> shadings[] = {{"clay", Shading::clay},
                                                             {"occlusion", Shading::occlusion},
                                                             {"direct", Shading::direct},
                                                             {"reflection", Shading::reflection},
                                                             {"cost", Shading::cost}};

constexpr std::pair<std::string_view, bool shade::Planes::*> planes[] = {
    {"combined", &shade::Planes::combined},
    {"depth", &shade::Planes::depth},
    {"normal", &shade::Planes::normal},
    {"object_index", &shade::Planes::object_index},
    {"cost", &shade::Planes::cost}};

template <typename Table>
std::string names_of(const Table& table) {
  std::string text;
  for (const auto& row : table) text += (text.empty() ? "" : ", ") + std::string(row.first);
  return text;
}

void check_range(const char* what, std::uint32_t value, std::uint32_t highest) {
  if (value >= 1 && value <= highest) return;
  throw std::invalid_argument(std::string("render: ") + what + " must be 1 to " +
                              std::to_string(highest) + ", got " + std::to_string(value));
}

void set_plane(shade::Planes& wanted, const std::string& name) {
  const auto row = std::find_if(std::begin(planes), std::end(planes),
                                [&](const auto& plane) { return plane.first == name; });
  if (row == std::end(planes))
    throw std::invalid_argument("render: unknown pass \"" + name + "\"; there are " +
                                names_of(planes));
  wanted.*(row->second) = true;
}

}  // namespace

Shading parse_shading(std::string_view name) {
  for (const auto& [text, shading] : shadings)
    if (text == name) return shading;
  throw std::invalid_argument("render: unknown shading \"" + std::string(name) + "\"; there are " +
                              names_of(shadings));
}

std::string_view name(Shading shading) {
  return std::find_if(std::begin(shadings), std::end(shadings),
                      [&](const auto& row) { return row.second == shading; })
      ->first;
}

shade::Raster checked_raster(const RenderSettings& s) {
  check_range("width", s.width, max_side);
  check_range("height", s.height, max_side);
  const auto [x0, y0, x1, y1] = s.region;
  if ((x0 | y0 | x1 | y1) == 0) return {s.width, s.height, 0, 0, s.width, s.height};
  if (!(x0 < x1 && x1 <= s.width && y0 < y1 && y1 <= s.height))
    throw std::invalid_argument("render: region (" + std::to_string(x0) + ", " +
                                std::to_string(y0) + ", " + std::to_string(x1) + ", " +
                                std::to_string(y1) + ") is empty or not inside the image of " +
                                std::to_string(s.width) + " by " + std::to_string(s.height));
  return {s.width, s.height, x0, y0, x1, y1};
}

shade::ShadingSettings checked_shading(const RenderSettings& s) {
  check_range("samples", s.samples, max_samples);
  shade::ShadingSettings out{s.shading, s.samples, s.seed, s.transparent_background, {}};
  if (s.passes.empty()) throw std::invalid_argument("render: no pass is asked for");
  for (const std::string& pass : s.passes) set_plane(out.planes, pass);
  return out;
}

}  // namespace regraft::render
