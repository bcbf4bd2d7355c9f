#pragma once

#include <cstdint>

#include "regraft/trace/hit.h"
#include "regraft/trace/traverse_bvh.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

inline constexpr int lanes_all = int(packet_capacity);

/// The box-test part of 64 rays in one frame, and the box of all of them: with intervals for
/// origins and reciprocal directions one node test speaks for the whole packet (Boulos, Wald,
/// Shirley, Geometric and Arithmetic Culling Methods for Entire Ray Packets, 2006).
struct alignas(64) SlabPacket {
  float near_origin[3][lanes_all];
  float far_origin[3][lanes_all];
  float inverse[3][lanes_all];
  float near_origin_lo[3], near_origin_hi[3];
  float far_origin_lo[3], far_origin_hi[3];
  float inverse_lo[3], inverse_hi[3];
  bool negative[3];
  bool bounded[3];  ///< false: some ray is parallel to the axis' planes; no interval to test
};

/// Fills the packet as `set_slabs` would, ray by ray.
/// @return false if the rays do not agree on the sign of every direction component: such a
/// packet is traced ray by ray.
REGRAFT_INLINE bool set_slab_packet(SlabPacket& packet, const float (&origin)[3][lanes_all],
                                    const float (&direction)[3][lanes_all], float magnitude) {
  for (int k = 0; k < 3; ++k) {
    packet.negative[k] = std::signbit(direction[k][0]);
    bool same = true;
    for (int i = 0; i < lanes_all; ++i) same &= std::signbit(direction[k][i]) == packet.negative[k];
    if (!same) return false;
  }
  alignas(64) float slack[lanes_all];
  for (int i = 0; i < lanes_all; ++i) {
    float largest = magnitude;
    for (int k = 0; k < 3; ++k) {
      const float o = std::fabs(origin[k][i]);
      largest = o > largest ? o : largest;
    }
    slack[i] = box_slack * largest;
  }
  for (int k = 0; k < 3; ++k) {
    const float sign = packet.negative[k] ? -1.0f : 1.0f;
    for (int i = 0; i < lanes_all; ++i) {
      packet.inverse[k][i] = 1.0f / direction[k][i];
      packet.near_origin[k][i] = origin[k][i] + sign * slack[i];
      packet.far_origin[k][i] = origin[k][i] - sign * slack[i];
    }
  }
  return true;
}

REGRAFT_INLINE void range_of(const float (&values)[lanes_all], float& lo, float& hi) {
  lo = hi = values[0];
  for (int i = 1; i < lanes_all; ++i) {
    lo = values[i] < lo ? values[i] : lo;
    hi = values[i] > hi ? values[i] : hi;
  }
}

REGRAFT_INLINE void set_intervals(SlabPacket& packet) {
  for (int k = 0; k < 3; ++k) {
    range_of(packet.near_origin[k], packet.near_origin_lo[k], packet.near_origin_hi[k]);
    range_of(packet.far_origin[k], packet.far_origin_lo[k], packet.far_origin_hi[k]);
    range_of(packet.inverse[k], packet.inverse_lo[k], packet.inverse_hi[k]);
    packet.bounded[k] = packet.inverse_lo[k] > -infinity && packet.inverse_hi[k] < infinity;
  }
}

/// Which slots any ray of the packet may enter. Rounding is monotone, so the bounds hold for
/// what `test_box` computes, not only for what it approximates.
template <int W>
REGRAFT_INLINE LaneBits test_slots_packet(const WideNode<W>& node, const SlabPacket& packet,
                                          float start, float limit, Float<W>& near) {
  near = Float<W>(start);
  Float<W> far(limit);
  for (int k = 0; k < 3; ++k) {
    if (!packet.bounded[k]) continue;
    const bool negative = packet.negative[k];
    const Float<W> lo(packet.inverse_lo[k]), hi(packet.inverse_hi[k]);
    const Float<W> x = Float<W>::load(node.bounds[negative ? 3 + k : k]) -
                       Float<W>(negative ? packet.near_origin_lo[k] : packet.near_origin_hi[k]);
    const Float<W> y = Float<W>::load(node.bounds[negative ? k : 3 + k]) -
                       Float<W>(negative ? packet.far_origin_hi[k] : packet.far_origin_lo[k]);
    near = max(min(x * lo, x * hi), near);
    far = min(max(y * lo, y * hi), far);
  }
  return near <= far;
}

/// Lanes [base, base + R) against one box; the same operations as `box_interval`.
template <int R>
REGRAFT_INLINE LaneBits test_box(const SlabPacket& packet, const float (&lo)[3],
                                 const float (&hi)[3], int base, Float<R> near, Float<R> far) {
  for (int k = 0; k < 3; ++k)
    widen_axis(
        Float<R>(packet.negative[k] ? hi[k] : lo[k]), Float<R>(packet.negative[k] ? lo[k] : hi[k]),
        Float<R>::load(packet.near_origin[k] + base), Float<R>::load(packet.far_origin[k] + base),
        Float<R>::load(packet.inverse[k] + base), near, far);
  return near <= far;
}

/// 64 rays in an instance's object space; see `LocalRay`. Packets are never remapped.
struct alignas(64) LocalPacket : SlabPacket {
  float origin[3][lanes_all];
  float shear[3][lanes_all];
  float entry[lanes_all];
  float exit[lanes_all];
  int kz;
};

/// Takes the rays of `mask` to object space; `mask` loses those that miss the instance's box.
/// @return false if they must be traced one by one there.
template <int R>
REGRAFT_INLINE bool make_local_packet(const RayPacket& rays, const SlabPacket& top,
                                      const InstanceView& instance, std::uint64_t& mask,
                                      LocalPacket& local) {
  std::uint64_t entered = 0;
  for (int base = 0; base < lanes_all; base += R) {
    Float<R> near(-infinity), far(infinity);
    for (int k = 0; k < 3; ++k)
      widen_axis(Float<R>(top.negative[k] ? instance.hi[k] : instance.lo[k]),
                 Float<R>(top.negative[k] ? instance.lo[k] : instance.hi[k]),
                 Float<R>::load(top.near_origin[k] + base),
                 Float<R>::load(top.far_origin[k] + base), Float<R>::load(top.inverse[k] + base),
                 near, far);
    near.store(local.entry + base);
    far.store(local.exit + base);
    const LaneBits lanes = (near <= far) & (Float<R>::load(rays.t_near + base) <= far);
    entered |= std::uint64_t(lanes) << base;
  }
  mask &= entered;
  if (mask == 0) return true;

  alignas(64) float direction[3][lanes_all];
  const double* m = instance.world_to_object;
  bool remapped = false;
  for (int i = 0; i < lanes_all; ++i) {
    double o[3], d[3];
    double distance = 0.0, length = 0.0;
    for (int k = 0; k < 3; ++k, m += 4) {
      o[k] =
          ((m[0] * rays.origin[0][i] + m[1] * rays.origin[1][i]) + m[2] * rays.origin[2][i]) + m[3];
      d[k] =
          (m[0] * rays.direction[0][i] + m[1] * rays.direction[1][i]) + m[2] * rays.direction[2][i];
      const double a = std::fabs(o[k] - instance.mesh.center[k]);
      const double b = std::fabs(d[k]);
      distance = a > distance ? a : distance;
      length = b > length ? b : length;
      local.origin[k][i] = float(o[k]);
      direction[k][i] = float(d[k]);
    }
    m -= 12;
    remapped |= distance > 64.0 * instance.mesh.radius || !(length < 0x1p100 && length > 0x1p-100);
  }
  if (remapped) return false;
  if (!set_slab_packet(local, local.origin, direction, instance.mesh.magnitude)) return false;

  const auto axis = [&](int i) {
    const float ax = std::fabs(direction[0][i]);
    const float ay = std::fabs(direction[1][i]);
    const float az = std::fabs(direction[2][i]);
    return ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2;
  };
  local.kz = axis(0);
  bool same = true;
  for (int i = 1; i < lanes_all; ++i) same &= axis(i) == local.kz;
  if (!same) return false;
  const int kx = local.kz == 2 ? 0 : local.kz + 1;
  const int ky = kx == 2 ? 0 : kx + 1;
  for (int i = 0; i < lanes_all; ++i) {
    local.shear[0][i] = direction[kx][i] / direction[local.kz][i];
    local.shear[1][i] = direction[ky][i] / direction[local.kz][i];
    local.shear[2][i] = 1.0f / direction[local.kz][i];
  }
  set_intervals(local);
  return true;
}

/// One ray of a packet as `make_local` would have made it.
REGRAFT_INLINE LocalRay extract(const LocalPacket& packet, const RayPacket& rays, int i) {
  LocalRay ray;
  for (int k = 0; k < 3; ++k) {
    ray.near_origin[k] = packet.near_origin[k][i];
    ray.far_origin[k] = packet.far_origin[k][i];
    ray.inverse[k] = packet.inverse[k][i];
    ray.near_plane[k] = packet.negative[k] ? 3 + k : k;
    ray.far_plane[k] = packet.negative[k] ? k : 3 + k;
    ray.origin[k] = packet.origin[k][i];
    ray.shear[k] = packet.shear[k][i];
  }
  ray.kz = packet.kz;
  ray.t_near = rays.t_near[i];
  ray.entry = packet.entry[i];
  ray.exit = packet.exit[i];
  ray.t0 = 0.0;
  ray.scale = 1.0;
  ray.remapped = false;
  return ray;
}

REGRAFT_INLINE SlabRay extract_top(const SlabPacket& packet, int i) {
  SlabRay ray;
  for (int k = 0; k < 3; ++k) {
    ray.near_origin[k] = packet.near_origin[k][i];
    ray.far_origin[k] = packet.far_origin[k][i];
    ray.inverse[k] = packet.inverse[k][i];
    ray.near_plane[k] = packet.negative[k] ? 3 + k : k;
    ray.far_plane[k] = packet.negative[k] ? k : 3 + k;
  }
  return ray;
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
