#pragma once

#include <array>
#include <cstdint>

#include "regraft/core/vec.h"

namespace regraft {

enum class CameraKind : std::uint8_t {
  perspective,
  orthographic,
  equirectangular,
  fisheye_equidistant,
  fisheye_equisolid,
};

/// Camera frame: looks along −Z, Y up, X right. See docs/api.md for the fields' meaning.
struct Camera {
  CameraKind kind = CameraKind::perspective;
  Mat4d camera_to_world{1.0};
  /// left, right, bottom, top: one unit before the eye (perspective), world units
  /// (orthographic), relative to the image circle (fisheye).
  std::array<double, 4> window{-1.0, 1.0, -1.0, 1.0};
  double clip_near = 0.0;
  double clip_far = 1e30;
  std::array<double, 2> latitude{-1.5707963267948966, 1.5707963267948966};
  std::array<double, 2> longitude{-3.141592653589793, 3.141592653589793};
  /// Full angle of the fisheye's image circle, radians.
  double fov = 3.141592653589793;
};

}  // namespace regraft
