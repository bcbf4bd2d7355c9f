#pragma once

#include "regraft/shade/lights.h"
#include "regraft/shade/tallied_tracer.h"

namespace regraft::shade {

/// Surfaces behind one another that a ray passes; the last of them counts as opaque.
inline constexpr int max_layers = 8;

/// How light gets from lights to surfaces in one frame.
struct Visibility {
  /// A material lets light through: shadow rays look at what they hit.
  bool transparency = false;
};

/// Share of the light that arrives at each lane of `illumination.lit`; 0 elsewhere. All rays of
/// the packet towards the light are traced together; `from_centre`: they end in one point.
void shadows(const PreparedLight& light, const Illumination& illumination, bool from_centre,
             const SurfaceLanes& surface, Visibility visibility, TalliedTracer& tracer,
             InstanceCache& instances, FloatLanes& passed);

/// Moves a packet on behind what it hit: the rays keep their origin, so nothing can be met twice.
inline void step_behind(const trace::HitPacket& hits, LaneMask lanes, trace::RayPacket& rays) {
  for_each_lane(lanes, [&](std::uint32_t i) {
    rays.t_near[i] = std::nextafter(hits.t[i], std::numeric_limits<float>::infinity());
  });
  rays.active = lanes;
}

}  // namespace regraft::shade
