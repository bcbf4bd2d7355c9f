#pragma once

#include <bit>
#include <cstdint>

#include "regraft/trace/packet_rays.h"
#include "regraft/trace/single.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// `Nearest` of 64 rays.
struct alignas(64) NearestPacket {
  float t[lanes_all];
  float u[lanes_all]{};
  float v[lanes_all]{};
  std::uint32_t instance_id[lanes_all];
  std::uint32_t prim_id[lanes_all];

  REGRAFT_INLINE explicit NearestPacket(const RayPacket& rays) {
    for (int i = 0; i < lanes_all; ++i) {
      t[i] = rays.t_far[i];
      instance_id[i] = prim_id[i] = 0xFFFFFFFFu;
    }
  }

  REGRAFT_INLINE Nearest at(int i) const { return {t[i], instance_id[i], prim_id[i], u[i], v[i]}; }

  REGRAFT_INLINE void take(int i, const Nearest& n) {
    t[i] = n.t;
    instance_id[i] = n.instance_id;
    prim_id[i] = n.prim_id;
    u[i] = n.u;
    v[i] = n.v;
  }

  /// The largest t any ray of `mask` still cares for.
  template <int R>
  REGRAFT_INLINE float limit(std::uint64_t mask) const {
    constexpr auto full = LaneBits((std::uint64_t(1) << R) - 1);
    Float<R> largest(-infinity);
    for (int base = 0; base < lanes_all; base += R)
      if ((mask >> base & full) != 0) largest = max(Float<R>::load(t + base), largest);
    return highest_lane(largest);
  }

  /// Writes the rays of `active`; a miss has t = inf.
  REGRAFT_INLINE void store(std::uint64_t active, HitPacket& hits) const {
    if (active != ~std::uint64_t(0)) {
      for (; active != 0; active &= active - 1) {
        const int i = std::countr_zero(active);
        store_hit(hits, std::uint32_t(i), at(i));
      }
      return;
    }
    for (int i = 0; i < lanes_all; ++i) {
      hits.t[i] = prim_id[i] == 0xFFFFFFFFu ? infinity : t[i];
      hits.u[i] = u[i];
      hits.v[i] = v[i];
      hits.instance_id[i] = instance_id[i];
      hits.prim_id[i] = prim_id[i];
    }
  }
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
