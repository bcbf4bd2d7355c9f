#pragma once

#include <bit>
#include <cstdint>

#include "regraft/trace/hit.h"
#include "regraft/trace/traverse_bvh.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

inline constexpr int lanes_all = int(packet_capacity);

/// The lanes of `rays` that are `valid`.
REGRAFT_INLINE std::uint64_t valid_lanes(const RayPacket& rays) {
  alignas(64) double length[lanes_all], reach[lanes_all];
  for (int i = 0; i < lanes_all; ++i) length[i] = reach[i] = 0.0;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < lanes_all; ++i) {
      length[i] += std::fabs(rays.direction[k][i]);
      reach[i] += std::fabs(rays.origin[k][i]);
    }
  const auto good = [&](int i) {
    return (length[i] > 0.0) & (length[i] < 0x1p127) & (reach[i] < 0x1p120) &
           (rays.t_near[i] <= rays.t_far[i]);
  };
  int count = 0;
  for (int i = 0; i < lanes_all; ++i) count += good(i);
  if (count == lanes_all) return ~std::uint64_t(0);
  std::uint64_t lanes = 0;
  for (int i = 0; i < lanes_all; ++i) lanes |= std::uint64_t(good(i)) << i;
  return lanes;
}

/// The box-test part of 64 rays in one frame, and the box of all of them: with intervals for
/// origins and reciprocal directions one node test speaks for the whole packet (Boulos, Wald,
/// Shirley, Geometric and Arithmetic Culling Methods for Entire Ray Packets, 2006).
struct alignas(64) SlabPacket {
  float near_origin[3][lanes_all];
  float far_origin[3][lanes_all];
  float inverse[3][lanes_all];
  std::uint64_t negatives[3];  ///< rays whose direction has the sign bit
  // The rest is set if all rays agree on the signs of their directions' components.
  float near_origin_lo[3], near_origin_hi[3];
  float far_origin_lo[3], far_origin_hi[3];
  float inverse_lo[3], inverse_hi[3];
  bool negative[3];
  bool bounded[3];  ///< false: some ray is parallel to the axis' planes; no interval to test
};

/// Bit i: value i has the sign bit.
template <int R>
REGRAFT_INLINE std::uint64_t sign_mask(const float (&values)[lanes_all]) {
  std::uint64_t mask = 0;
  for (int base = 0; base < lanes_all; base += R)
    mask |= std::uint64_t(sign_bits(Float<R>::load(values + base))) << base;
  return mask;
}

/// Fills the packet as `set_slabs` would, ray by ray, but for the intervals. `share`: of the
/// largest coordinate at hand, the slack.
/// @return true if the rays agree on the sign of every direction component.
template <int R>
REGRAFT_INLINE bool set_slab_packet(SlabPacket& packet, const float (&origin)[3][lanes_all],
                                    const float (&direction)[3][lanes_all], float magnitude,
                                    float share = box_slack) {
  alignas(64) float slack[lanes_all];
  for (int i = 0; i < lanes_all; ++i) slack[i] = magnitude;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < lanes_all; ++i) {
      const float o = std::fabs(origin[k][i]);
      slack[i] = o > slack[i] ? o : slack[i];
    }
  for (int i = 0; i < lanes_all; ++i) slack[i] *= share;
  bool agree = true;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < lanes_all; ++i) {
      const float outward = std::copysign(slack[i], direction[k][i]);
      packet.inverse[k][i] = 1.0f / direction[k][i];
      packet.near_origin[k][i] = origin[k][i] + outward;
      packet.far_origin[k][i] = origin[k][i] - outward;
    }
    packet.negatives[k] = sign_mask<R>(direction[k]);
    packet.negative[k] = packet.negatives[k] != 0;
    agree &= packet.negatives[k] == 0 || packet.negatives[k] == ~std::uint64_t(0);
  }
  return agree;
}

/// Least and largest value; one that is NaN does not count.
template <int R>
REGRAFT_INLINE void range_of(const float (&values)[lanes_all], float& lo, float& hi) {
  Float<R> least(infinity), largest(-infinity);
  for (int base = 0; base < lanes_all; base += R) {
    const Float<R> v = Float<R>::load(values + base);
    least = min(v, least);
    largest = max(v, largest);
  }
  lo = lowest_lane(least);
  hi = highest_lane(largest);
}

template <int R>
REGRAFT_INLINE void set_intervals(SlabPacket& packet) {
  for (int k = 0; k < 3; ++k) {
    range_of<R>(packet.near_origin[k], packet.near_origin_lo[k], packet.near_origin_hi[k]);
    range_of<R>(packet.far_origin[k], packet.far_origin_lo[k], packet.far_origin_hi[k]);
    range_of<R>(packet.inverse[k], packet.inverse_lo[k], packet.inverse_hi[k]);
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

/// 64 rays in an instance's object space; see `LocalRay`. None of them is remapped.
struct alignas(64) LocalPacket : SlabPacket {
  float origin[3][lanes_all];
  float direction[3][lanes_all];
  float entry[lanes_all];
  float exit[lanes_all];
  std::uint64_t kz_is[3];
  // The rest is set if the rays are together.
  float shear[2][lanes_all];  ///< the third is the inverse of axis kz
  int kz;
  bool together;  ///< they agree on signs and kz: interval culling is possible
};

/// `box_interval` of every ray; @return the rays that meet the box in [t_near, ∞).
template <int R>
REGRAFT_INLINE std::uint64_t meet_box(const SlabPacket& rays, const float (&t_near)[lanes_all],
                                      const float (&lo)[3], const float (&hi)[3],
                                      float (&entry)[lanes_all], float (&exit)[lanes_all]) {
  for (int i = 0; i < lanes_all; ++i) {
    entry[i] = -infinity;
    exit[i] = infinity;
  }
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < lanes_all; ++i) {
      const bool negative = std::signbit(rays.inverse[k][i]);
      const float near = ((negative ? hi[k] : lo[k]) - rays.near_origin[k][i]) * rays.inverse[k][i];
      const float far = ((negative ? lo[k] : hi[k]) - rays.far_origin[k][i]) * rays.inverse[k][i];
      entry[i] = near > entry[i] ? near : entry[i];
      exit[i] = far < exit[i] ? far : exit[i];
    }
  std::uint64_t met = 0;
  for (int base = 0; base < lanes_all; base += R) {
    const Float<R> far = Float<R>::load(exit + base);
    met |= std::uint64_t((Float<R>::load(entry + base) <= far) &
                         (Float<R>::load(t_near + base) <= far))
           << base;
  }
  return met;
}

/// `needs_remap`, ray by ray: those further away than `reach`, or of extreme length.
REGRAFT_INLINE std::uint64_t far_lanes(const double (&distance)[lanes_all],
                                       const double (&length)[lanes_all], double reach) {
  int fine = 0;
  for (int i = 0; i < lanes_all; ++i)
    fine += !(distance[i] > reach) & (length[i] < 0x1p100) & (length[i] > 0x1p-100);
  if (fine == lanes_all) return 0;
  std::uint64_t lanes = 0;
  for (int i = 0; i < lanes_all; ++i) {
    const bool far = distance[i] > reach || !(length[i] < 0x1p100 && length[i] > 0x1p-100);
    lanes |= std::uint64_t(far) << i;
  }
  return lanes;
}

/// `to_object` and `needs_remap` of every ray; @return those that do.
REGRAFT_INLINE std::uint64_t to_object(const InstanceView& instance, const RayPacket& rays,
                                       LocalPacket& local) {
  alignas(64) double distance[lanes_all], length[lanes_all];
  for (int i = 0; i < lanes_all; ++i) distance[i] = length[i] = 0.0;
  const double* p = instance.position;
  for (int k = 0; k < 3; ++k) {
    const double* m = instance.world_to_object + 3 * k;
    const double center = instance.mesh.center[k];
    const auto convert = [&](int i, double o, double d) {
      const double a = std::fabs(o - center);
      const double b = std::fabs(d);
      distance[i] = a > distance[i] ? a : distance[i];
      length[i] = b > length[i] ? b : length[i];
      local.origin[k][i] = float(o);
      local.direction[k][i] = float(d);
    };
    const double(&o)[3][lanes_all] = rays.origin;
    const double(&d)[3][lanes_all] = rays.direction;
    if (instance.identity)
      for (int i = 0; i < lanes_all; ++i) convert(i, o[k][i], d[k][i]);
    else
      for (int i = 0; i < lanes_all; ++i)
        convert(i, (m[0] * (o[0][i] - p[0]) + m[1] * (o[1][i] - p[1])) + m[2] * (o[2][i] - p[2]),
                (m[0] * d[0][i] + m[1] * d[1][i]) + m[2] * d[2][i]);
  }
  return far_lanes(distance, length, 64.0 * instance.mesh.radius);
}

/// Rays by the axis of their largest |direction|, chosen as in `set_shear`.
template <int R>
REGRAFT_INLINE void set_axes(LocalPacket& local) {
  local.kz_is[0] = local.kz_is[1] = 0;
  for (int base = 0; base < lanes_all; base += R) {
    Float<R> size[3];
    for (int k = 0; k < 3; ++k) {
      size[k] = abs(Float<R>::load(local.direction[k] + base));
    }
    const LaneBits x = (size[0] >= size[1]) & (size[0] >= size[2]);
    local.kz_is[0] |= std::uint64_t(x) << base;
    local.kz_is[1] |= std::uint64_t(~x & (size[1] >= size[2])) << base;
  }
  local.kz_is[2] = ~(local.kz_is[0] | local.kz_is[1]);
}

REGRAFT_INLINE void set_shears(LocalPacket& local) {
  const int kz = local.kz;
  const int kx = kz == 2 ? 0 : kz + 1;
  const int ky = kx == 2 ? 0 : kx + 1;
  for (int i = 0; i < lanes_all; ++i) {
    local.shear[0][i] = local.direction[kx][i] / local.direction[kz][i];
    local.shear[1][i] = local.direction[ky][i] / local.direction[kz][i];
  }
}

/// Takes all rays to object space; `mask` loses those that miss the instance's box.
/// @return rays of `mask` that have to be taken there one by one.
template <int R>
REGRAFT_INLINE std::uint64_t make_local_packet(const RayPacket& rays, const SlabPacket& top,
                                               const InstanceView& instance, std::uint64_t& mask,
                                               LocalPacket& local) {
  mask &= meet_box<R>(top, rays.t_near, instance.lo, instance.hi, local.entry, local.exit);
  if (mask == 0) return 0;
  const std::uint64_t remapped = to_object(instance, rays, local) & mask;
  local.together =
      set_slab_packet<R>(local, local.origin, local.direction, instance.mesh.magnitude) &&
      remapped == 0;
  set_axes<R>(local);
  for (int k = 0; k < 3; ++k)
    if (local.kz_is[k] == ~std::uint64_t(0))
      local.kz = k;
    else if (local.kz_is[k] != 0)
      local.together = false;
  if (!local.together) return remapped;
  set_shears(local);
  set_intervals<R>(local);
  return 0;
}

/// The box-test part of one ray of a packet.
REGRAFT_INLINE void extract_slabs(const SlabPacket& packet, int i, SlabRay& ray) {
  for (int k = 0; k < 3; ++k) {
    const int negative = int(packet.negatives[k] >> i & 1u);
    ray.near_origin[k] = packet.near_origin[k][i];
    ray.far_origin[k] = packet.far_origin[k][i];
    ray.inverse[k] = packet.inverse[k][i];
    ray.near_plane[k] = k + 3 * negative;
    ray.far_plane[k] = k + 3 - 3 * negative;
  }
}

/// One ray of a packet as `make_local` would have made it.
REGRAFT_INLINE LocalRay extract(const LocalPacket& packet, const RayPacket& rays, int i) {
  LocalRay ray;
  extract_slabs(packet, i, ray);
  for (int k = 0; k < 3; ++k) ray.origin[k] = packet.origin[k][i];
  ray.kz = int(packet.kz_is[1] >> i & 1u) + 2 * int(packet.kz_is[2] >> i & 1u);
  const int kx = ray.kz == 2 ? 0 : ray.kz + 1;
  const int ky = kx == 2 ? 0 : kx + 1;
  ray.shear[0] = packet.direction[kx][i] / packet.direction[ray.kz][i];
  ray.shear[1] = packet.direction[ky][i] / packet.direction[ray.kz][i];
  ray.shear[2] = ray.inverse[ray.kz];
  ray.t_near = rays.t_near[i];
  ray.entry = packet.entry[i];
  ray.exit = packet.exit[i];
  ray.t0 = 0.0;
  ray.scale = 1.0;
  ray.remapped = false;
  return ray;
}

/// One packet in `sample_every`, by what its first ray is: the same ones for any number of threads.
REGRAFT_INLINE bool is_sampled(const RayPacket& rays) {
  if (rays.active == 0) return false;
  const int i = std::countr_zero(rays.active);
  std::uint64_t bits = 0;
  for (int k = 0; k < 3; ++k) {
    bits = (bits ^ std::bit_cast<std::uint64_t>(rays.origin[k][i])) * 0x9E3779B97F4A7C15u;
    bits = (bits ^ std::bit_cast<std::uint64_t>(rays.direction[k][i])) * 0x9E3779B97F4A7C15u;
    bits ^= bits >> 32;
  }
  return bits % sample_every == 0;
}

/// Lanes that carry no ray get a copy of one that does, so that registers hold no rubbish.
REGRAFT_INLINE const RayPacket& filled(const RayPacket& rays, RayPacket& copy) {
  if (rays.active == ~std::uint64_t(0) || rays.active == 0) return rays;
  copy = rays;
  const int source = std::countr_zero(rays.active);
  for (int i = 0; i < lanes_all; ++i) {
    if ((rays.active >> i & 1u) != 0) continue;
    for (int k = 0; k < 3; ++k) {
      copy.origin[k][i] = rays.origin[k][source];
      copy.direction[k][i] = rays.direction[k][source];
    }
    copy.t_near[i] = rays.t_near[source];
    copy.t_far[i] = rays.t_far[source];
  }
  return copy;
}

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
