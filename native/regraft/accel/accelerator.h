#pragma once

#include <memory>

#include "regraft/accel/update_policy.h"
#include "regraft/accel/update_statistics.h"
#include "regraft/core/aabb.h"
#include "regraft/core/executor.h"
#include "regraft/scene/scene.h"
#include "regraft/trace/trace_view.h"

namespace regraft::accel {

/// Keeps the trees of a scene up to date and shows them to the tracer. Does not shade.
class Accelerator {
 public:
  Accelerator();
  ~Accelerator();
  Accelerator(Accelerator&&) noexcept;
  Accelerator& operator=(Accelerator&&) noexcept;

  /// Brings every tree in line with `scene`, given what changed since the last call.
  UpdateStatistics update(const Scene& scene, const ChangeSet& changes,
                          const UpdateOptions& options, Executor& executor);

  /// Valid until the next `update`.
  const trace::TraceView& view() const;

  /// World box of what can be hit, double; lo > hi when there is nothing.
  std::pair<Vec3d, Vec3d> world_bounds() const;

  /// Shading normals of a mesh by normal id, object space; empty for a flat mesh.
  std::span<const Vec3> shading_normals(std::uint32_t mesh) const;

  /// For tests and studies: every tree checked, the first violation in words or "".
  std::string validate(const Scene& scene) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace regraft::accel
