#pragma once

#include <bit>
#include <cstdint>

#include "regraft/trace/packet_rays.h"
#include "regraft/trace/traverse_kdtree.h"

namespace regraft::trace::REGRAFT_SIMD_NAMESPACE {

/// 64 rays in the frame of a k-d tree; see `make_cell_ray`.
struct alignas(64) CellRayPacket : SlabPacket {
  SlabPacket top;          ///< as boxes of instances meet them
  std::uint64_t remapped;  ///< rays that come from far away: to be traced one by one

  /// `near`, `far` receive what each ray has of the tree's box.
  /// @return the rays that meet it.
  template <int R>
  REGRAFT_INLINE std::uint64_t set(const TraceView& view, const RayPacket& rays,
                                   float (&near)[lanes_all], float (&far)[lanes_all]) {
    const Aabb& bounds = view.kdtree->bounds();
    const MeshView all = as_mesh(bounds);
    alignas(64) float origin[3][lanes_all], direction[3][lanes_all];
    alignas(64) double distance[lanes_all], length[lanes_all];
    for (int i = 0; i < lanes_all; ++i) distance[i] = length[i] = 0.0;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < lanes_all; ++i) {
        const double o = rays.origin[k][i] - view.scene_origin[k];
        const double away = std::fabs(o - all.center[k]);
        const double size = std::fabs(rays.direction[k][i]);
        distance[i] = away > distance[i] ? away : distance[i];
        length[i] = size > length[i] ? size : length[i];
        origin[k][i] = float(o);
        direction[k][i] = float(rays.direction[k][i]);
      }
    remapped = far_lanes(distance, length, 64.0 * all.radius);
    set_slab_packet<R>(top, origin, direction, view.magnitude);
    set_slab_packet<R>(*this, origin, direction, all.magnitude, cell_slack * box_slack);
    const float lo[3] = {bounds.lo.x, bounds.lo.y, bounds.lo.z};
    const float hi[3] = {bounds.hi.x, bounds.hi.y, bounds.hi.z};
    const std::uint64_t met = meet_box<R>(*this, rays.t_near, lo, hi, near, far);
    for (int i = 0; i < lanes_all; ++i)
      near[i] = near[i] > rays.t_near[i] ? near[i] : rays.t_near[i];
    return met;
  }

  /// The rays whose directions have the signs of those of ray i.
  REGRAFT_INLINE std::uint64_t octant_of(int i) const {
    std::uint64_t alike = ~std::uint64_t(0);
    for (int k = 0; k < 3; ++k)
      alike &= (negatives[k] >> i & 1u) != 0 ? negatives[k] : ~negatives[k];
    return alike;
  }

  /// What `make_cell_ray` would have made of ray i, but for what only triangles need.
  REGRAFT_INLINE LocalRay cell_ray(const RayPacket& rays, int i) const {
    LocalRay ray{};
    extract_slabs(*this, i, ray);
    ray.t_near = rays.t_near[i];
    ray.scale = 1.0;
    return ray;
  }
};

/// An instance as rays of one octant see it.
struct Place {
  LocalPacket local;
  std::uint32_t object = 0xFFFFFFFFu;
  std::uint64_t together;  ///< rays that meet its box and whose signs are those of `local.negative`
  std::uint64_t apart;     ///< rays that meet its box, to be tested one by one

  template <int R>
  REGRAFT_INLINE void set(const RayPacket& rays, const SlabPacket& top,
                          const InstanceView& instance, std::uint64_t octant) {
    together = apart = 0;
    local.kz = -1;
    const std::uint64_t met =
        octant & meet_box<R>(top, rays.t_near, instance.lo, instance.hi, local.entry, local.exit);
    if (met == 0) return;
    remapped = to_object(instance, rays, local) & met;
    set_slab_packet<R>(local, local.origin, local.direction, instance.mesh.magnitude);
    set_axes<R>(local);
    together = met & ~remapped;
    if (together != 0) {
      const int first = std::countr_zero(together);
      for (int k = 0; k < 3; ++k) {
        local.negative[k] = (local.negatives[k] >> first & 1u) != 0;
        together &= local.negative[k] ? local.negatives[k] : ~local.negatives[k];
      }
    }
    apart = met & ~together;
  }

  /// Makes `kz` the axis of the shear.
  REGRAFT_INLINE void turn_to(int kz) {
    if (local.kz == kz) return;
    local.kz = kz;
    set_shears(local);
  }

  std::uint64_t remapped = 0;  ///< of `apart`: those that `local` does not hold
};

/// The instances that a packet was lately in.
class Places {
 public:
  /// What follows is for rays of this octant.
  REGRAFT_INLINE void begin(std::uint64_t octant) {
    octant_ = octant;
    for (Place& place : places_) place.object = 0xFFFFFFFFu;
  }

  template <int R>
  REGRAFT_INLINE Place& at(const RayPacket& rays, const SlabPacket& top,
                           const InstanceView* instances, std::uint32_t object) {
    Place& place = places_[object % size];
    if (place.object == object) return place;
    place.object = object;
    place.set<R>(rays, top, instances[object], octant_);
    return place;
  }

 private:
  static constexpr std::uint32_t size = 4;
  std::uint64_t octant_ = 0;
  Place places_[size];
};

}  // namespace regraft::trace::REGRAFT_SIMD_NAMESPACE
