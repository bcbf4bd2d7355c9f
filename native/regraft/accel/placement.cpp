#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "regraft/accel/instance_set.h"
#include "regraft/core/rounding.h"

namespace regraft::accel {

namespace {

/// Condition number above which an inverse loses too much (N6).
constexpr double bake_condition = 1e6;

/// As much of a mesh's largest coordinate as kernels widen boxes by in object space.
constexpr double object_slack = 0x1p-19;

/// World coordinates from here on leave no room below the largest float for sums and slacks.
constexpr double largest_reach = 0x1p120;

bool all_finite(const Mat4d& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r)
      if (!std::isfinite(m[c][r])) return false;
  return true;
}

double max_norm(const Mat3d& m) {
  double norm = 0.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) norm = std::fmax(norm, std::fabs(m[c][r]));
  return norm;
}

}  // namespace

Placement classify(const Mat4d& object_to_world) {
  if (!all_finite(object_to_world)) return Placement::not_finite;
  Mat3d linear(object_to_world);
  const double norm = max_norm(linear);
  if (norm == 0.0) return Placement::no_area;
  // Scaled to entries of at most 1: a tiny determinant then means a bad shape, not a small one.
  linear /= norm;
  const double determinant = glm::determinant(linear);
  if (determinant != 0.0) {
    const double condition = max_norm(glm::inverse(linear));
    if (condition < bake_condition && std::isfinite(1.0 / norm)) return Placement::direct;
  }
  std::array<Vec3d, 3> minors{glm::cross(linear[0], linear[1]), glm::cross(linear[1], linear[2]),
                              glm::cross(linear[2], linear[0])};
  const bool has_area = std::any_of(minors.begin(), minors.end(), [](const Vec3d& n) {
    return n.x != 0.0 || n.y != 0.0 || n.z != 0.0;
  });
  return has_area ? Placement::bake : Placement::no_area;
}

Placement classify(const Mat4d& object_to_world, const Aabb& box) {
  const Placement placement = classify(object_to_world);
  if (placement == Placement::not_finite || box.empty()) return placement;
  const Vec3d largest = glm::max(glm::abs(Vec3d(box.lo)), glm::abs(Vec3d(box.hi)));
  for (int r = 0; r < 3; ++r) {
    double reach = std::fabs(object_to_world[3][r]);
    for (int c = 0; c < 3; ++c) reach += std::fabs(object_to_world[c][r]) * largest[c];
    if (!(reach < largest_reach)) return Placement::too_large;
  }
  return placement;
}

Vec3d placement_margin(const Mat4d& m, const Aabb& world, float magnitude) {
  Vec3d margin;
  const double pad = world.magnitude() * 0x1p-22;
  for (int r = 0; r < 3; ++r)
    margin[r] = object_slack * double(magnitude) *
                    (std::fabs(m[0][r]) + std::fabs(m[1][r]) + std::fabs(m[2][r])) +
                pad;
  return margin;
}

Aabb transform_bounds(const Mat4d& m, const Aabb& box, float magnitude) {
  if (box.empty()) return {};
  const Vec3d center = 0.5 * (Vec3d(box.lo) + Vec3d(box.hi));
  const Vec3d half = 0.5 * box.extents() + object_slack * double(magnitude);
  Aabb result;
  double largest = 0.0;
  Vec3d lo, hi;
  for (int r = 0; r < 3; ++r) {
    const double c = ((m[0][r] * center.x + m[1][r] * center.y) + m[2][r] * center.z) + m[3][r];
    const double h =
        (std::fabs(m[0][r]) * half.x + std::fabs(m[1][r]) * half.y) + std::fabs(m[2][r]) * half.z;
    lo[r] = c - h;
    hi[r] = c + h;
    largest = std::fmax(largest, std::fmax(std::fabs(lo[r]), std::fabs(hi[r])));
  }
  const double pad = largest * 0x1p-22;
  for (int r = 0; r < 3; ++r) {
    result.lo[r] = round_down(lo[r] - pad);
    result.hi[r] = round_up(hi[r] + pad);
  }
  return result;
}

}  // namespace regraft::accel
