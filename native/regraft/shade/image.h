#pragma once

#include <cstdint>
#include <vector>

namespace regraft::shade {

/// One plane of output: float32, rows from the bottom up (Blender's order), interleaved channels.
struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 0;
  std::vector<float> pixels;

  Image() = default;
  Image(std::uint32_t w, std::uint32_t h, std::uint32_t c, float value = 0.0f)
      : width(w), height(h), channels(c), pixels(std::size_t(w) * h * c, value) {}
  float* pixel(std::uint32_t x, std::uint32_t y) {
    return pixels.data() + (std::size_t(y) * width + x) * channels;
  }
};

}  // namespace regraft::shade
