#include "regraft/shade/camera_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace regraft::shade {

namespace {

/// Bits of the eight columns (or rows) of a tile at `first` that lie in [lo, hi).
std::uint32_t inside(std::uint32_t first, std::uint32_t lo, std::uint32_t hi) {
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < 8; ++i)
    bits |= std::uint32_t(first + i >= lo && first + i < hi) << i;
  return bits;
}

bool is_fisheye(CameraKind kind) {
  return kind == CameraKind::fisheye_equidistant || kind == CameraKind::fisheye_equisolid;
}

bool is_panoramic(CameraKind kind) {
  return is_fisheye(kind) || kind == CameraKind::equirectangular;
}

/// left, right, bottom, top of the film in the camera's own coordinates; radians for the
/// equirectangular one.
std::array<double, 4> film_window(const Camera& camera) {
  if (camera.kind != CameraKind::equirectangular) return camera.window;
  return {camera.longitude[0], camera.longitude[1], camera.latitude[0], camera.latitude[1]};
}

/// Least distance along −Z at which the box begins, a little before it.
double box_entry(const Vec3d& eye, const Vec3d& back, const Vec3d& lo, const Vec3d& hi) {
  double entry = 0.0;
  for (int k = 0; k < 3; ++k)
    entry += std::min(-back[k] * (lo[k] - eye[k]), -back[k] * (hi[k] - eye[k]));
  return entry - 1e-3 * glm::length(hi - lo);
}

}  // namespace

Tile make_tile(const Raster& raster, std::uint32_t x0, std::uint32_t y0) {
  const std::uint32_t columns = inside(x0, raster.x0, raster.x1);
  const std::uint32_t rows = inside(y0, raster.y0, raster.y1);
  Tile tile{x0, y0, 0};
  for (std::uint32_t row = 0; row < 8; ++row)
    if ((rows >> row & 1u) != 0) tile.active |= LaneMask(columns) << (8 * row);
  return tile;
}

/// Film coordinates of a tile's points.
struct CameraRays::Film {
  DoubleLanes x, y;
};

CameraRays::CameraRays(const Camera& camera, const Raster& raster, const Vec3d& scene_lo,
                       const Vec3d& scene_hi)
    : camera_(camera),
      right_(glm::normalize(Vec3d(camera.camera_to_world[0]))),
      up_(glm::normalize(Vec3d(camera.camera_to_world[1]))),
      back_(glm::normalize(Vec3d(camera.camera_to_world[2]))),
      eye_(camera.camera_to_world[3]) {
  const auto [left, right, bottom, top] = film_window(camera);
  step_x_ = (right - left) / raster.width;
  step_y_ = (top - bottom) / raster.height;
  first_x_ = left;
  first_y_ = bottom;
  if (camera.kind == CameraKind::orthographic) {
    start_ = camera.clip_near;
    if (scene_lo.x <= scene_hi.x)
      start_ = std::max(start_, box_entry(eye_, back_, scene_lo, scene_hi));
    if (!std::isfinite(start_)) start_ = 0.0;
  }
  t_near_ = float(std::max(0.0, camera.clip_near - start_));
  t_far_ = float(camera.clip_far - start_);
}

void CameraRays::generate(const Tile& tile, const PointLanes& offsets,
                          trace::RayPacket& rays) const {
  Film film;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    film.x[i] = first_x_ + step_x_ * (double(tile.x0 + i % 8) + double(offsets.u[i]));
    film.y[i] = first_y_ + step_y_ * (double(tile.y0 + i / 8) + double(offsets.v[i]));
  }
  rays.count = lane_count;
  rays.active = tile.active;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    rays.t_near[i] = t_near_;
    rays.t_far[i] = t_far_;
  }
  if (is_panoramic(camera_.kind))
    rays.active &= generate_panoramic(film, rays);
  else if (camera_.kind == CameraKind::orthographic)
    generate_parallel(film, rays);
  else
    generate_perspective(film, rays);
}

void CameraRays::generate_perspective(const Film& film, trace::RayPacket& rays) const {
  for (int k = 0; k < 3; ++k) {
    const double right = right_[k], up = up_[k], back = back_[k], eye = eye_[k];
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      rays.direction[k][i] = right * film.x[i] + up * film.y[i] - back;
      rays.origin[k][i] = eye;
    }
  }
}

void CameraRays::generate_parallel(const Film& film, trace::RayPacket& rays) const {
  for (int k = 0; k < 3; ++k) {
    const double right = right_[k], up = up_[k], back = back_[k];
    const double origin = eye_[k] - back * start_;
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      rays.direction[k][i] = -back;
      rays.origin[k][i] = origin + right * film.x[i] + up * film.y[i];
    }
  }
}

LaneMask CameraRays::generate_panoramic(const Film& film, trace::RayPacket& rays) const {
  LaneMask reached = 0;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    Vec3d local;
    reached |= LaneMask(panoramic_direction(film.x[i], film.y[i], local)) << i;
    const Vec3d world = right_ * local.x + up_ * local.y + back_ * local.z;
    for (int k = 0; k < 3; ++k) {
      rays.direction[k][i] = world[k];
      rays.origin[k][i] = eye_[k];
    }
  }
  return reached;
}

/// Direction in the camera's frame. Equidistant: the angle to the axis grows as the distance r
/// from the centre of the circle; equisolid: r as the sine of half that angle.
/// @return false outside a fisheye's circle.
bool CameraRays::panoramic_direction(double x, double y, Vec3d& direction) const {
  if (!is_fisheye(camera_.kind)) {
    direction = {std::sin(x) * std::cos(y), std::sin(y), -std::cos(x) * std::cos(y)};
    return true;
  }
  const double r = std::hypot(x, y);
  const double angle = camera_.kind == CameraKind::fisheye_equidistant
                           ? r * camera_.fov / 2
                           : 2 * std::asin(std::min(1.0, r * std::sin(camera_.fov / 4)));
  const double across = r > 0.0 ? std::sin(angle) / r : 0.0;
  direction = {across * x, across * y, -std::cos(angle)};
  return r <= 1.0;
}

float CameraRays::distance(const trace::RayPacket& rays, std::uint32_t i, float t) const {
  const Vec3d direction(rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
  return float((double(t) + start_) * glm::length(direction));
}

}  // namespace regraft::shade
