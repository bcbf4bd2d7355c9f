#pragma once

#include "regraft/shade/instance_cache.h"
#include "regraft/shade/lanes.h"
#include "regraft/trace/hit.h"

namespace regraft::shade {

/// The triangles a packet's rays hit, as found in their meshes: object space. Every lane is
/// defined: those without a hit repeat one that has, so that later loops need no mask.
struct Corners {
  Vec3Lanes point[3];
  Vec3Lanes normal[3];  ///< unit; zero on flat triangles; undefined unless `smooth`
  FloatLanes u, v;
  Lanes<std::uint32_t> prim_id;
  Lanes<std::uint32_t> instance_id;
  bool smooth = false;        ///< some triangle has shading normals
  bool one_instance = false;  ///< all lanes are of the same instance
};

/// Reads what the lanes `active` of `hits` hit; at least one must be active.
void read_corners(const trace::HitPacket& hits, LaneMask active, InstanceCache& instances,
                  Corners& out);

/// Calls `body(instance, begin, end)` for runs of lanes that share an instance; a copy of it, so
/// that the compiler can keep its matrix in registers.
template <typename Body>
void for_each_run(const Corners& corners, InstanceCache& instances, const Body& body) {
  std::uint32_t end = corners.one_instance ? lane_count : 0;
  for (std::uint32_t begin = 0; begin < lane_count; begin = end) {
    const std::uint32_t id = corners.instance_id[begin];
    for (end = corners.one_instance ? lane_count : begin + 1;
         end < lane_count && corners.instance_id[end] == id;)
      ++end;
    const ShadedInstance instance = instances.find(id);
    body(instance, begin, end);
  }
}

}  // namespace regraft::shade
