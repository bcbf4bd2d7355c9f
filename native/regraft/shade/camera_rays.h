#pragma once

#include <cstdint>

#include "regraft/scene/camera.h"
#include "regraft/shade/lanes.h"
#include "regraft/shade/sampler.h"
#include "regraft/trace/hit.h"

namespace regraft::shade {

/// Size of an image and the region of it that is wanted: pixels [x0, x1) × [y0, y1), from the
/// lower left corner.
struct Raster {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t x0 = 0;
  std::uint32_t y0 = 0;
  std::uint32_t x1 = 0;
  std::uint32_t y1 = 0;
};

/// An 8×8 tile of the image; tiles lie on multiples of eight whatever the region, so that a
/// region is bit for bit the crop of the whole image. Lane i is pixel (x0 + i % 8, y0 + i / 8).
struct Tile {
  std::uint32_t x0 = 0;
  std::uint32_t y0 = 0;
  LaneMask active = 0;
};

/// The part of the tile at (x0, y0) that lies in the region.
Tile make_tile(const Raster& raster, std::uint32_t x0, std::uint32_t y0);

/// World-space rays through the pixels of an image, double precision.
///
/// Perspective rays keep the length that makes their component along −Z one, so that t is the
/// distance from the eye's plane and clipping is the same t range for all of them; the other
/// cameras' directions are unit vectors.
class CameraRays {
 public:
  /// `scene_lo`, `scene_hi`: world box of what can be hit (lo > hi: nothing). An orthographic
  /// camera's rays start where they meet it, since its near plane may be very far away.
  CameraRays(const Camera& camera, const Raster& raster, const Vec3d& scene_lo,
             const Vec3d& scene_hi);

  /// Rays of `tile` through the points `offsets` of each pixel's unit square. Pixels that the
  /// lens does not reach (outside a fisheye's circle) are not active.
  void generate(const Tile& tile, const PointLanes& offsets, trace::RayPacket& rays) const;

  /// Distance from the eye (orthographic: from the eye's plane) along ray i to its hit at t.
  float distance(const trace::RayPacket& rays, std::uint32_t i, float t) const;

  /// Where the eye stands.
  const Vec3d& eye() const { return eye_; }

 private:
  struct Film;
  void generate_parallel(const Film& film, trace::RayPacket& rays) const;
  void generate_perspective(const Film& film, trace::RayPacket& rays) const;
  LaneMask generate_panoramic(const Film& film, trace::RayPacket& rays) const;
  bool panoramic_direction(double x, double y, Vec3d& direction) const;

  Camera camera_;
  Vec3d right_, up_, back_, eye_;
  /// Film coordinates are first + step · pixel.
  double first_x_, first_y_, step_x_, step_y_;
  /// Where rays start, as t along them from the eye.
  double start_ = 0.0;
  float t_near_, t_far_;
};

}  // namespace regraft::shade
