#pragma once

#include "regraft/shade/sampler.h"
#include "regraft/shade/surface.h"
#include "regraft/shade/tallied_tracer.h"

namespace regraft::shade {

/// Occlusion rays a pixel gets at least, over all its samples.
inline constexpr std::uint32_t occlusion_rays = 8;

/// How far occlusion reaches in a scene with this world box: a quarter of its mean extent
/// (geometric mean; an extent counts at least 1 % of the longest, so that a flat scene has some
/// too).
float occlusion_radius(const Vec3d& lo, const Vec3d& hi);

/// Openness of surfaces to their surroundings, 0 to 1.
class Occlusion {
 public:
  /// `samples`: samples a pixel, which share out `occlusion_rays` between them.
  Occlusion(float radius, std::uint32_t samples, std::uint64_t seed);

  /// Share of the hemisphere about each shading normal, cosine-weighted, from which nothing is
  /// nearer than a length that varies from 0 to the radius from ray to ray: what is far occludes
  /// little and there is no edge where the reach ends.
  void openness(const SurfaceLanes& surface, std::uint32_t x0, std::uint32_t y0,
                std::uint32_t sample, TalliedTracer& tracer, FloatLanes& open) const;

 private:
  float radius_;
  std::uint32_t rays_;
  Sampler sampler_;
};

}  // namespace regraft::shade
