#pragma once

#include <functional>
#include <set>
#include <string>

#include "regraft/accel/accelerator.h"
#include "regraft/core/executor.h"
#include "regraft/render/frame.h"
#include "regraft/scene/camera.h"
#include "regraft/scene/scene.h"
#include "regraft/trace/tracer.h"

namespace regraft::render {

enum class Shading { clay, occlusion, direct, reflection, cost };

struct RenderSettings {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  Shading shading = Shading::direct;
  std::uint32_t samples = 1;
  std::uint64_t seed = 0;
  /// Names as in docs/api.md; unknown ones throw.
  std::set<std::string> passes{"combined"};
  /// Pixels x0, y0, x1, y1 from the lower left corner, half open; all 0: the whole image.
  std::array<std::uint32_t, 4> region{0, 0, 0, 0};
  /// Called on the calling thread about every 20 ms with the finished fraction; returning false
  /// cancels.
  std::function<bool(double)> poll;
};

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
  Frame render(const Camera& camera, const RenderSettings& settings);

  /// Throws std::logic_error if the scene changed since the last `update`.
  trace::Tracer tracer() const;
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
