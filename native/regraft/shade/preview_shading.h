#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "regraft/accel/accelerator.h"
#include "regraft/scene/scene.h"
#include "regraft/shade/camera_rays.h"
#include "regraft/shade/occlusion.h"
#include "regraft/shade/reflectance.h"
#include "regraft/shade/tallied_tracer.h"
#include "regraft/shade/visibility.h"

namespace regraft::shade {

/// What a picture shows; see docs/api.md.
enum class Shading { clay, occlusion, direct, reflection, cost };

/// Which output planes are wanted; the others are not computed.
struct Planes {
  bool combined = false;
  bool depth = false;
  bool normal = false;
  bool object_index = false;
  bool cost = false;
};

struct ShadingSettings {
  Shading shading = Shading::direct;
  std::uint32_t samples = 1;
  std::uint64_t seed = 0;
  /// Nothing is seen where no surface is; otherwise the world's colour is, opaque.
  bool transparent_background = false;
  Planes planes;
};

/// What all tiles of a picture share; constant while it is rendered.
class PictureShading {
 public:
  PictureShading(const Scene& scene, const accel::Accelerator& accelerator,
                 const trace::Tracer& tracer, const CameraRays& camera,
                 const ShadingSettings& settings);

  const Scene& scene;
  const accel::Accelerator& accelerator;
  const trace::Tracer tracer;
  const CameraRays& camera;
  const ShadingSettings settings;
  std::vector<PreparedLight> lights;
  Vec3 world;
  bool headlight;         ///< the scene has no lights
  Visibility visibility;  ///< whether any material lets light through
  Sampler sampler;
  Occlusion occlusion;
};

/// The pixels of a tile, lane i as in `Tile`; planes that are not wanted stay undefined.
struct TilePixels {
  FloatLanes combined[4];  ///< premultiplied linear RGBA
  FloatLanes depth;
  Vec3Lanes normal;
  FloatLanes object_index;
  FloatLanes cost;
};

/// Renders tiles, one after the other; each worker has its own.
class TileShader {
 public:
  TileShader(const PictureShading& picture, const std::atomic<bool>& cancelled);

  /// @return false if it was cancelled before the tile was finished; `out` is then undefined.
  bool render(const Tile& tile, TilePixels& out);

  const RayTally& tally() const { return tracer_.tally(); }
  bool met_smooth() const { return instances_.met_smooth(); }

 private:
  /// Colour times coverage, and coverage.
  struct Layers {
    Vec3Lanes color;
    FloatLanes alpha;
  };
  /// Primary rays of one sample and what they hit.
  struct Sight {
    trace::RayPacket rays;
    trace::HitPacket hits;
    LaneMask hit = 0;
    Lanes<std::uint32_t> cost;
    SurfaceLanes surface;  ///< found only if `hit` is not 0 and somebody asked
  };

  void look(std::uint32_t sample, Sight& sight);
  void keep_data(const Sight& sight, TilePixels& out) const;
  void add_sample(Sight& sight, TilePixels& out);
  SurfaceNeeds needs() const;

  void combine(Sight& sight, Layers& out);
  void clay(const Sight& sight, Layers& out) const;
  void occlude(const Sight& sight, Layers& out);
  void heat(const Sight& sight, Layers& out) const;
  void show(LaneMask hit, const FloatLanes& grey, Layers& out) const;

  void lit_layers(Sight& sight, bool mirrors, float world_alpha, Layers& out);
  void shade(const SurfaceLanes& surface, const MaterialLanes& material, bool mirrors,
             Vec3Lanes& radiance);
  void add_lights(const SurfaceLanes& surface, const ReflectanceLanes& reflectance, bool mirrors,
                  Vec3Lanes& radiance);
  void add_mirror(const SurfaceLanes& surface, const MaterialLanes& material,
                  const FloatLanes& share, Vec3Lanes& radiance);

  const PictureShading& picture_;
  const std::atomic<bool>& cancelled_;
  TalliedTracer tracer_;
  InstanceCache instances_;
  Tile tile_;
  std::uint32_t sample_ = 0;
};

}  // namespace regraft::shade
