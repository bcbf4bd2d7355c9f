#pragma once

#include "regraft/accel/accelerator.h"
#include "regraft/core/executor.h"
#include "regraft/render/frame.h"
#include "regraft/render/render_settings.h"
#include "regraft/scene/camera.h"
#include "regraft/scene/scene.h"
#include "regraft/trace/tracer.h"

namespace regraft::render {

/// The façade: a scene, its trees and a thread pool. Bound to Python as `regraft.Scene`.
///
/// modify → update → trace: `render` and the queries throw std::logic_error while the scene has
/// changes that `update` has not seen.
class Renderer {
 public:
  Renderer(unsigned threads, simd::Isa isa);

  Scene& scene() { return scene_; }
  const Scene& scene() const { return scene_; }
  Executor& executor() { return executor_; }

  accel::UpdateStatistics update(const accel::UpdateOptions& options);
  /// One picture. Throws std::invalid_argument naming a setting that is wrong; an exception of
  /// `settings.poll` passes through. Deterministic: the same pixels for any number of threads and
  /// any instruction set. The statistics begin with those of the last update, whose work the
  /// first frame after it answers for.
  Frame render(const Camera& camera, const RenderSettings& settings);

  /// Throws std::logic_error if the scene changed since the last `update`.
  trace::Tracer tracer() const;
  /// Rays that were traced by `tracer`: how well trees are kept depends on their number. From any
  /// thread.
  void note_rays(std::uint64_t rays) { accelerator_.note_rays(rays); }
  const accel::Accelerator& accelerator() const { return accelerator_; }
  simd::Isa isa() const { return isa_; }

 private:
  Scene scene_;
  accel::Accelerator accelerator_;
  Executor executor_;
  simd::Isa isa_;
  accel::UpdateStatistics last_update_;
};

}  // namespace regraft::render
