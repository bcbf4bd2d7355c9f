#pragma once

#include <cstdint>

#include "regraft/trace/packet_nearest.h"
#include "regraft/trace/packet_rays.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// A triangle on its way through a packet.
class PacketTriangle {
 public:
  REGRAFT_INLINE PacketTriangle(const MeshView& mesh, std::uint32_t prim) : prim_(prim) {
    const std::uint32_t* index = mesh.triangles + 3 * std::size_t(prim);
    for (int i = 0; i < 3; ++i) vertex_[i] = mesh.vertices + 3 * std::size_t(index[i]);
    for (int k = 0; k < 3; ++k) {
      lo_[k] = lowest(lowest(vertex_[0][k], vertex_[1][k]), vertex_[2][k]);
      hi_[k] = highest(highest(vertex_[0][k], vertex_[1][k]), vertex_[2][k]);
    }
  }

  /// Tests it against the rays of `mask`, R at a time. They are together in `local`, the object
  /// space of `instance`. Nearest hits go to `best`, unless any hit will do.
  /// @return the rays that hit it before what was nearest or equally near.
  template <int R, bool AnyHit>
  REGRAFT_INLINE std::uint64_t test(const RayPacket& rays, const LocalPacket& local,
                                    const InstanceView& instance, std::uint64_t mask,
                                    NearestPacket& best) const {
    constexpr auto full = LaneBits((std::uint64_t(1) << R) - 1);
    std::uint64_t hit = 0;
    for (int base = 0; base < lanes_all; base += R) {
      const auto wanted = LaneBits(mask >> base & full);
      if (wanted == 0) continue;
      const LaneBits lanes = test_lanes<R, AnyHit>(rays, local, instance, base, wanted, best);
      hit |= std::uint64_t(lanes) << base;
    }
    return hit;
  }

 private:
  /// `test_triangles` with the roles exchanged.
  template <int R, bool AnyHit>
  REGRAFT_INLINE LaneBits test_lanes(const RayPacket& rays, const LocalPacket& local,
                                     const InstanceView& instance, int base, LaneBits wanted,
                                     NearestPacket& best) const {
    const int axes[3] = {local.kz == 2 ? 0 : local.kz + 1, local.kz == 0 ? 2 : local.kz - 1,
                         local.kz};
    Float<R> relative[3][3];
    for (int k = 0; k < 3; ++k) {
      const Float<R> origin = Float<R>::load(local.origin[axes[k]] + base);
      for (int i = 0; i < 3; ++i) relative[i][k] = Float<R>(vertex_[i][axes[k]]) - origin;
    }
    const Float<R> start = Float<R>::load(rays.t_near + base);
    const Float<R> entry = Float<R>::load(local.entry + base);
    const EdgeTest<R> test(
        relative[0], relative[1], relative[2], Float<R>::load(local.shear[0] + base),
        Float<R>::load(local.shear[1] + base), Float<R>::load(local.inverse[local.kz] + base),
        [&](const Float<R>& latest) { return (latest < start) & (entry < start); });
    LaneBits lanes = test.hit & wanted;
    if (lanes == 0) return 0;
    Float<R> near(-infinity), far(infinity);
    for (int k = 0; k < 3; ++k)
      widen_axis(Float<R>(local.negative[k] ? hi_[k] : lo_[k]),
                 Float<R>(local.negative[k] ? lo_[k] : hi_[k]),
                 Float<R>::load(local.near_origin[k] + base),
                 Float<R>::load(local.far_origin[k] + base),
                 Float<R>::load(local.inverse[k] + base), near, far);
    const Float<R> local_t = min(far, max(near, test.t));
    const Float<R> t = min(Float<R>::load(local.exit + base), max(entry, local_t));
    lanes &= (near <= far) & (start <= far) & (start <= t) & (t <= Float<R>::load(best.t + base));
    lanes &= (Float<R>(-infinity) < t) & (t < Float<R>(infinity));
    if (lanes == 0 || lacks_area(instance.mesh, prim_)) return 0;
    if (!AnyHit) take(instance, base, lanes, t, test.v / test.det, test.w / test.det, best);
    return lanes;
  }

  template <int R>
  REGRAFT_INLINE void take(const InstanceView& instance, int base, LaneBits lanes, Float<R> t,
                           Float<R> u, Float<R> v, NearestPacket& best) const {
    alignas(64) float ts[R], us[R], vs[R];
    t.store(ts), u.store(us), v.store(vs);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int i = __builtin_ctz(lanes);
      if (best.at(base + i).beaten_by(ts[i], instance.instance_id, prim_))
        best.take(base + i, {ts[i], instance.instance_id, prim_, us[i], vs[i]});
    }
  }

  static float lowest(float a, float b) { return a < b ? a : b; }
  static float highest(float a, float b) { return a > b ? a : b; }

  std::uint32_t prim_;
  const float* vertex_[3];
  float lo_[3], hi_[3];
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
