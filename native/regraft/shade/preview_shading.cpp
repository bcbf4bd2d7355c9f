#include "regraft/shade/preview_shading.h"

#include <algorithm>
#include <cmath>

#include "regraft/shade/heat_map.h"

namespace regraft::shade {

namespace {

/// Clay: grey, brightest where it faces the viewer, never black.
constexpr float clay_edge = 0.06f;
constexpr float clay_face = 0.60f;

bool any_transparent(const Scene& scene) {
  const auto materials = scene.materials();
  return std::any_of(materials.begin(), materials.end(),
                     [](const Material& m) { return m.base_color.w < 1.0f; });
}

float occlusion_reach(const accel::Accelerator& accelerator) {
  const auto [lo, hi] = accelerator.world_bounds();
  return occlusion_radius(lo, hi);
}

}  // namespace

PictureShading::PictureShading(const Scene& scene_in, const accel::Accelerator& accelerator_in,
                               const trace::Tracer& tracer_in, const CameraRays& camera_in,
                               const ShadingSettings& settings_in)
    : scene(scene_in),
      accelerator(accelerator_in),
      tracer(tracer_in),
      camera(camera_in),
      settings(settings_in),
      lights(prepare_lights(scene.lights())),
      world(scene.world()),
      headlight(scene.lights().empty()),
      visibility{any_transparent(scene)},
      sampler(settings.seed, settings.samples),
      occlusion(occlusion_reach(accelerator), settings.samples, settings.seed) {}

TileShader::TileShader(const PictureShading& picture, const std::atomic<bool>& cancelled)
    : picture_(picture),
      cancelled_(cancelled),
      tracer_(picture.tracer),
      instances_(picture.scene, picture.accelerator) {}

bool TileShader::render(const Tile& tile, TilePixels& out) {
  tile_ = tile;
  for (FloatLanes& channel : out.combined) channel.fill(0.0f);
  out.cost.fill(0.0f);
  Sight sight;
  for (sample_ = 0; sample_ < picture_.settings.samples; ++sample_) {
    if (cancelled_.load(std::memory_order_relaxed)) return false;
    look(sample_, sight);
    if (sample_ == 0) keep_data(sight, out);
    add_sample(sight, out);
  }
  const float share = 1.0f / float(picture_.settings.samples);
  for (FloatLanes& channel : out.combined)
    for (float& value : channel.value) value *= share;
  for (float& value : out.cost.value) value *= share;
  return true;
}

SurfaceNeeds TileShader::needs() const {
  SurfaceNeeds needs;
  if (!picture_.settings.planes.combined) return needs;
  const Shading shading = picture_.settings.shading;
  needs.materials = shading == Shading::direct || shading == Shading::reflection;
  needs.positions = needs.materials || shading == Shading::occlusion;
  return needs;
}

/// Traces the primary rays of a sample and finds the surfaces, if anything wants to know them.
void TileShader::look(std::uint32_t sample, Sight& sight) {
  const ShadingSettings& s = picture_.settings;
  PointLanes offsets;
  if (s.samples > 1) {
    picture_.sampler.points(tile_.x0, tile_.y0, sample, std::uint32_t(Dimension::pixel), offsets);
  } else {
    offsets.u.fill(0.5f);
    offsets.v.fill(0.5f);
  }
  picture_.camera.generate(tile_, offsets, sight.rays);
  const bool heat = s.planes.combined && s.shading == Shading::cost;
  if (s.planes.cost || heat)
    tracer_.primary_with_cost(sight.rays, sight.hits, sight.cost.value);
  else
    tracer_.primary(sight.rays, sight.hits);
  sight.hit = hit_lanes(sight.hits, sight.rays.active);
  if (sight.hit != 0 && (s.planes.normal || (s.planes.combined && s.shading != Shading::cost)))
    find_surfaces(sight.rays, sight.hits, sight.hit, needs(), instances_, sight.surface);
}

/// The planes that are not averaged: a mean of two depths or two object numbers means nothing.
void TileShader::keep_data(const Sight& sight, TilePixels& out) const {
  const Planes& planes = picture_.settings.planes;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const bool hit = has_lane(sight.hit, i);
    if (planes.depth)
      out.depth[i] = hit ? picture_.camera.distance(sight.rays, i, sight.hits.t[i])
                         : std::numeric_limits<float>::infinity();
    if (planes.object_index)
      out.object_index[i] =
          hit ? float(picture_.scene.instances()[sight.hits.instance_id[i]].object_index) : 0.0f;
    if (planes.normal) {
      out.normal.x[i] = hit ? sight.surface.normal.x[i] : 0.0f;
      out.normal.y[i] = hit ? sight.surface.normal.y[i] : 0.0f;
      out.normal.z[i] = hit ? sight.surface.normal.z[i] : 0.0f;
    }
  }
}

void TileShader::add_sample(Sight& sight, TilePixels& out) {
  const Planes& planes = picture_.settings.planes;
  if (planes.cost)
    for_each_lane(sight.rays.active, [&](std::uint32_t i) { out.cost[i] += float(sight.cost[i]); });
  if (!planes.combined) return;
  const LaneMask active = sight.rays.active;
  Layers layers;
  FloatLanes weight;
  combine(sight, layers);
  set_weights(active, weight);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    out.combined[0][i] += weight[i] * layers.color.x[i];
    out.combined[1][i] += weight[i] * layers.color.y[i];
    out.combined[2][i] += weight[i] * layers.color.z[i];
    out.combined[3][i] += weight[i] * layers.alpha[i];
  }
}

void TileShader::combine(Sight& sight, Layers& out) {
  const float world_alpha = picture_.settings.transparent_background ? 0.0f : 1.0f;
  switch (picture_.settings.shading) {
    case Shading::clay:
      return clay(sight, out);
    case Shading::occlusion:
      return occlude(sight, out);
    case Shading::direct:
      return lit_layers(sight, false, world_alpha, out);
    case Shading::reflection:
      return lit_layers(sight, true, world_alpha, out);
    case Shading::cost:
      return heat(sight, out);
  }
}

/// Opaque surfaces where something was hit, the world elsewhere.
void TileShader::show(LaneMask hit, const FloatLanes& grey, Layers& out) const {
  const float alpha = picture_.settings.transparent_background ? 0.0f : 1.0f;
  const Vec3 color = picture_.world * alpha;
  FloatLanes here;
  set_weights(hit, here);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float surface = here[i] * grey[i], rest = 1.0f - here[i];
    out.color.x[i] = surface + rest * color.x;
    out.color.y[i] = surface + rest * color.y;
    out.color.z[i] = surface + rest * color.z;
    out.alpha[i] = here[i] + rest * alpha;
  }
}

void TileShader::clay(const Sight& sight, Layers& out) const {
  const Vec3Lanes& n = sight.surface.normal;
  const Vec3Lanes& v = sight.surface.view;
  FloatLanes grey;
  if (sight.hit == 0) {
    grey.fill(0.0f);
  } else {
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      const float facing = n.x[i] * v.x[i] + (n.y[i] * v.y[i] + n.z[i] * v.z[i]);
      grey[i] = clay_edge + (clay_face - clay_edge) * max_of(facing, 0.0f);
    }
  }
  show(sight.hit, grey, out);
}

void TileShader::occlude(const Sight& sight, Layers& out) {
  FloatLanes open;
  if (sight.hit == 0)
    open.fill(0.0f);
  else
    picture_.occlusion.openness(sight.surface, tile_.x0, tile_.y0, sample_, tracer_, open);
  show(sight.hit, open, out);
}

/// The heat map covers the background too: rays that hit nothing have their cost as well.
void TileShader::heat(const Sight& sight, Layers& out) const {
  for_each_lane(sight.rays.active, [&](std::uint32_t i) {
    const Vec3 color = heat_color(float(sight.cost[i]));
    out.color.x[i] = color.x;
    out.color.y[i] = color.y;
    out.color.z[i] = color.z;
  });
  out.alpha.fill(1.0f);
}

}  // namespace regraft::shade
