#pragma once

#include "regraft/shade/instance_cache.h"
#include "regraft/shade/lanes.h"
#include "regraft/trace/hit.h"

namespace regraft::shade {

/// What a shading mode wants to know of the surfaces that were hit.
struct SurfaceNeeds {
  bool positions = false;  ///< to send further rays from
  bool materials = false;
};

/// The surfaces a packet's rays hit, world frame. Surfaces have two sides: normals face the viewer.
struct SurfaceLanes {
  LaneMask active = 0;
  Vec3Lanes geometric;  ///< unit normal of the triangle
  Vec3Lanes normal;     ///< unit shading normal
  Vec3Lanes view;       ///< unit vector towards the ray's origin
  /// Where secondary rays start: off the triangle by more than tracing's rounding errors, and off
  /// a smooth-shaded one by as much as the curved surface it stands for.
  DoubleLanes position[3];
  const Material* material[lane_count];
  bool one_material = false;  ///< all lanes have the first one's; the others are not set
};

/// The lanes of `active` whose ray hit something.
inline LaneMask hit_lanes(const trace::HitPacket& hits, LaneMask active) {
  return lanes_below(hits.t, std::numeric_limits<float>::infinity()) & active;
}

/// Looks up what `hits` of the lanes `active` hit. At least one lane must be active.
void find_surfaces(const trace::RayPacket& rays, const trace::HitPacket& hits, LaneMask active,
                   SurfaceNeeds needs, InstanceCache& instances, SurfaceLanes& out);

}  // namespace regraft::shade
