#pragma once

#include <cstddef>
#include <cstdint>

#include "regraft/core/aligned.h"

namespace regraft::shade {

/// One plane of output: float32, rows from the bottom up (Blender's order), interleaved channels.
///
/// Without a value the pixels start undefined: whoever renders writes every one, on all threads,
/// instead of having one thread fill them with zeros first.
struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 0;
  AlignedVector<float> pixels;

  Image() = default;
  Image(std::uint32_t w, std::uint32_t h, std::uint32_t c)
      : width(w), height(h), channels(c), pixels(std::size_t(w) * h * c) {}
  Image(std::uint32_t w, std::uint32_t h, std::uint32_t c, float value)
      : width(w), height(h), channels(c), pixels(std::size_t(w) * h * c, value) {}
  float* pixel(std::uint32_t x, std::uint32_t y) {
    return pixels.data() + (std::size_t(y) * width + x) * channels;
  }
  const float* pixel(std::uint32_t x, std::uint32_t y) const {
    return pixels.data() + (std::size_t(y) * width + x) * channels;
  }
};

}  // namespace regraft::shade
