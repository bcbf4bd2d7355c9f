#include "regraft/render/renderer.h"

#include <chrono>
#include <stdexcept>

#include "regraft/accel/key_boxes.h"
#include "regraft/render/tile_loop.h"
#include "regraft/trace/kernels.h"

namespace regraft::render {

namespace {

using Clock = std::chrono::steady_clock;

/// Weight of a triangle test against a node (algorithms' Eq. 1, cost of a leaf).
constexpr double leaf_cost = 1.5;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bool is_lit(Shading shading) {
  return shading == Shading::direct || shading == Shading::reflection;
}

bool reads_normals(const shade::ShadingSettings& s) {
  return s.planes.normal || (s.planes.combined && s.shading != Shading::cost);
}

/// Wall time shared out between tracing and the rest as the workers' own time was.
void set_times(const LoopTally& tally, double wall_ms, FrameStatistics& s) {
  const double share =
      tally.total_ns > 0 ? double(tally.rays.trace_ns) / double(tally.total_ns) : 0.0;
  s.trace_ms = wall_ms * share;
  s.shade_ms = wall_ms - s.trace_ms;
}

/// The observed counterpart of C(root), which counts a node for every ray that enters it and speaks
/// of rays that hit the scene.
void set_counts(const shade::RayTally& rays, FrameStatistics& s) {
  trace::TraceCounters all = rays.primary;
  all += rays.shadow;
  all += rays.secondary;
  s.rays_primary = rays.primary.rays;
  s.rays_shadow = rays.shadow.rays;
  s.rays_secondary = rays.secondary.rays;
  s.nodes_visited = all.nodes_visited;
  s.triangle_tests = all.triangle_tests;
  if (all.rays_met != 0)
    s.observed_cost =
        (double(all.node_entries) + leaf_cost * double(all.triangle_tests)) / double(all.rays_met);
}

void list_left_out(const shade::PictureShading& picture, const LoopTally& tally,
                   FrameStatistics& s) {
  const shade::ShadingSettings& settings = picture.settings;
  const auto add = [&](const char* text) { s.left_out.emplace_back(text); };
  if (!settings.planes.combined) return add("combined not asked for: nothing shaded");
  if (is_lit(settings.shading)) {
    if (picture.headlight) add("no lights: headlight, no shadow rays");
    if (!picture.visibility.transparency) add("opaque materials: no alpha tests");
  } else {
    add("lights and materials not read: no shadow rays");
  }
  if (reads_normals(settings) && !tally.met_smooth) add("normals not read: flat shading");
}

/// Statistics of an update that a frame has already answered for.
accel::UpdateStatistics reported(accel::UpdateStatistics s) {
  s.clear_work("nothing changed since the last frame: no update");
  return s;
}

}  // namespace

Renderer::Renderer(unsigned threads, simd::Isa isa) : executor_(threads), isa_(isa) {
  trace::kernels(isa);
}

accel::UpdateStatistics Renderer::update(const accel::UpdateOptions& options) {
  if (options.policy == accel::Policy::shot) accel::require_key_frames(scene_, scene_.changes());
  const int width = trace::kernels(isa_).width;
  last_update_ = accelerator_.update(scene_, scene_.take_changes(), options, width, executor_);
  return last_update_;
}

trace::Tracer Renderer::tracer() const {
  if (!scene_.changes().empty())
    throw std::logic_error("the scene changed since its last update: call update() before tracing");
  return {accelerator_.view(), isa_};
}

Frame Renderer::render(const Camera& camera, const RenderSettings& settings) {
  const auto start = Clock::now();
  const shade::Raster raster = checked_raster(settings);
  const shade::ShadingSettings shading = checked_shading(settings);
  const trace::Tracer tracer = this->tracer();
  if (reads_normals(shading)) accelerator_.update_shading_normals(scene_, executor_);
  const auto [lo, hi] = accelerator_.world_bounds();
  const shade::CameraRays rays(camera, raster, lo, hi);
  const shade::PictureShading picture(scene_, accelerator_, tracer, rays, shading);
  TileLoop loop(picture, raster);
  Frame frame;
  frame.cancelled = !loop.run(executor_, settings.poll);
  frame.passes = loop.take_images();
  static_cast<accel::UpdateStatistics&>(frame.statistics) = last_update_;
  accelerator_.count_kdtree(frame.statistics);
  accelerator_.count_late(frame.statistics);
  last_update_ = reported(std::move(last_update_));
  set_counts(loop.tally().rays, frame.statistics);
  accelerator_.note_rays(frame.statistics.rays_primary + frame.statistics.rays_shadow +
                             frame.statistics.rays_secondary,
                         frame.statistics.nodes_visited, frame.statistics.triangle_tests);
  list_left_out(picture, loop.tally(), frame.statistics);
  set_times(loop.tally(), milliseconds_since(start), frame.statistics);
  return frame;
}

}  // namespace regraft::render
