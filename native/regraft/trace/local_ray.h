#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "regraft/simd/float_n.h"
#include "regraft/trace/trace_view.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// Boxes are widened by this much of the largest coordinate at hand, |origin| or |box|. It covers
/// the rounding of the slab test (three operations on |plane − origin| ≤ 2M: 2^-22.4 M) and of
/// the triangle test's shear (2^-20.4 M), so that no ray the triangle test accepts is lost on
/// the way down the tree. It stands in for the far-plane factor of Ize 2013.
inline constexpr float box_slack = 0x1p-19f;

/// One ray in world space, double precision.
struct WorldRay {
  double origin[3];
  double direction[3];
  float t_near;
  float t_far;
};

/// The part of a ray that box tests need, in one coordinate frame. The slack is in the origins:
/// near planes are measured from `near_origin`, far planes from `far_origin`.
struct SlabRay {
  float near_origin[3];
  float far_origin[3];
  float inverse[3];
  int near_plane[3];  ///< row of `WideNode::bounds`, by the sign bit of the inverse
  int far_plane[3];
};

REGRAFT_INLINE void set_slabs(SlabRay& ray, const float* origin, const float* direction,
                              float magnitude) {
  float largest = magnitude;
  for (int k = 0; k < 3; ++k)
    largest = std::fabs(origin[k]) > largest ? std::fabs(origin[k]) : largest;
  const float slack = box_slack * largest;
  for (int k = 0; k < 3; ++k) {
    const bool negative = std::signbit(direction[k]);
    ray.inverse[k] = 1.0f / direction[k];
    ray.near_origin[k] = origin[k] + (negative ? -slack : slack);
    ray.far_origin[k] = origin[k] - (negative ? -slack : slack);
    ray.near_plane[k] = negative ? 3 + k : k;
    ray.far_plane[k] = negative ? k : 3 + k;
  }
}

struct Interval {
  float near;
  float far;
};

/// Where the ray is inside the box; a NaN (origin on a plane the ray is parallel to) counts as
/// inside (numerics rule N2). Every box test of every kernel computes exactly this, and rounding
/// is monotone, so a box inside another never has the larger interval.
REGRAFT_INLINE Interval box_interval(const SlabRay& ray, const float* lo, const float* hi) {
  Interval r{-std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
  for (int k = 0; k < 3; ++k) {
    const bool negative = ray.near_plane[k] != k;
    const float near = ((negative ? hi[k] : lo[k]) - ray.near_origin[k]) * ray.inverse[k];
    const float far = ((negative ? lo[k] : hi[k]) - ray.far_origin[k]) * ray.inverse[k];
    r.near = near > r.near ? near : r.near;
    r.far = far < r.far ? far : r.far;
  }
  return r;
}

/// A ray in an instance's object space. `t` of the world ray is t0 + scale·t of this one; both
/// are neutral unless the origin is far from the mesh or the direction's length is extreme.
struct LocalRay : SlabRay {
  float origin[3];
  float shear[3];  ///< d[kx]/d[kz], d[ky]/d[kz], 1/d[kz]
  int kz;          ///< axis of the largest |direction|
  float t_near;
  float entry;  ///< least t at which a hit may be reported: where the instance's box begins
  float exit;   ///< and the largest: where it ends
  double t0;
  double scale;
  bool remapped;
};

struct LocalFrame {
  double origin[3];
  double direction[3];
};

REGRAFT_INLINE LocalFrame to_object(const InstanceView& instance, const double* o,
                                    const double* d) {
  LocalFrame r;
  if (instance.identity) {
    for (int k = 0; k < 3; ++k) {
      r.origin[k] = o[k];
      r.direction[k] = d[k];
    }
    return r;
  }
  const double* p = instance.position;
  const double from[3] = {o[0] - p[0], o[1] - p[1], o[2] - p[2]};
  for (int k = 0; k < 3; ++k) {
    const double* m = instance.world_to_object + 3 * k;
    r.origin[k] = (m[0] * from[0] + m[1] * from[1]) + m[2] * from[2];
    r.direction[k] = (m[0] * d[0] + m[1] * d[1]) + m[2] * d[2];
  }
  return r;
}

/// True if this ray's float version would lose too much: the origin lies many mesh sizes away,
/// or the direction's length leaves the range in which reciprocals are safe.
REGRAFT_INLINE bool needs_remap(const LocalFrame& f, const MeshView& mesh) {
  double distance = 0.0;
  double length = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double a = std::fabs(f.origin[k] - mesh.center[k]);
    const double b = std::fabs(f.direction[k]);
    distance = a > distance ? a : distance;
    length = b > length ? b : length;
  }
  return distance > 64.0 * mesh.radius || !(length < 0x1p100 && length > 0x1p-100);
}

/// Moves the origin to just before a mesh that is ahead or behind, in double, and brings the
/// direction's largest component to [1, 2) by a power of two.
REGRAFT_INLINE void remap(LocalFrame& f, const MeshView& mesh, double& t0, double& scale) {
  double length = 0.0;
  for (int k = 0; k < 3; ++k) length = std::fmax(length, std::fabs(f.direction[k]));
  int exponent = 0;
  if (length > 0.0 && std::isfinite(length)) std::frexp(length, &exponent);
  scale = std::ldexp(1.0, 1 - exponent);
  double along = 0.0;
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    f.direction[k] *= scale;
    along += (mesh.center[k] - f.origin[k]) * f.direction[k];
    squared += f.direction[k] * f.direction[k];
  }
  const double reach = 2.0 * mesh.radius * std::sqrt(squared);
  const bool outside = along > reach || along < -reach;
  const double skip = outside ? (along - reach) / squared : 0.0;
  for (int k = 0; k < 3; ++k) f.origin[k] += skip * f.direction[k];
  t0 = skip * scale;
}

REGRAFT_INLINE void set_shear(LocalRay& ray, const float* d) {
  const float ax = std::fabs(d[0]);
  const float ay = std::fabs(d[1]);
  const float az = std::fabs(d[2]);
  ray.kz = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2;
  const int kx = ray.kz == 2 ? 0 : ray.kz + 1;
  const int ky = kx == 2 ? 0 : kx + 1;
  ray.shear[0] = d[kx] / d[ray.kz];
  ray.shear[1] = d[ky] / d[ray.kz];
  ray.shear[2] = 1.0f / d[ray.kz];
}

/// The ray in the instance's object space.
/// @return false if the ray misses the instance's box: then nothing in it counts as hit.
REGRAFT_INLINE bool make_local(const WorldRay& world, const SlabRay& top,
                               const InstanceView& instance, LocalRay& ray) {
  const Interval box = box_interval(top, instance.lo, instance.hi);
  if (!(box.near <= box.far) || !(world.t_near <= box.far)) return false;
  LocalFrame frame = to_object(instance, world.origin, world.direction);
  ray.t0 = 0.0;
  ray.scale = 1.0;
  ray.remapped = needs_remap(frame, instance.mesh);
  if (ray.remapped) remap(frame, instance.mesh, ray.t0, ray.scale);
  float direction[3];
  for (int k = 0; k < 3; ++k) {
    ray.origin[k] = float(frame.origin[k]);
    direction[k] = float(frame.direction[k]);
  }
  set_slabs(ray, ray.origin, direction, instance.mesh.magnitude);
  set_shear(ray, direction);
  ray.t_near = world.t_near;
  ray.entry = box.near;
  ray.exit = box.far;
  return true;
}

/// Largest local t that may still become a world t ≤ `t`: rounded up, never too small.
REGRAFT_INLINE float local_limit(const LocalRay& ray, float t) {
  if (!ray.remapped) return t;
  const double up = double(std::nextafter(t, std::numeric_limits<float>::infinity()));
  return std::nextafter(float((up - ray.t0) / ray.scale), std::numeric_limits<float>::infinity());
}

/// Local t from which on a hit can have a world t ≥ t_near: rounded down.
REGRAFT_INLINE float local_start(const LocalRay& ray) {
  if (!ray.remapped) return ray.t_near;
  const double down = double(std::nextafter(ray.t_near, -std::numeric_limits<float>::infinity()));
  return std::nextafter(float((down - ray.t0) / ray.scale),
                        -std::numeric_limits<float>::infinity());
}

/// The world's t of a hit: never outside the instance's box, whatever the rounding, so neither
/// the top tree nor an interval that ends at the hit can hide it.
REGRAFT_INLINE float world_t(const LocalRay& ray, float t) {
  const float world = ray.remapped ? float(ray.t0 + ray.scale * double(t)) : t;
  const float late = ray.entry > world ? ray.entry : world;
  return ray.exit < late ? ray.exit : late;
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
