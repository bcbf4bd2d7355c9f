#pragma once

#include <span>
#include <vector>

#include "regraft/scene/scene.h"
#include "regraft/trace/trace_view.h"
#include "trace/rays.h"

namespace regraft::test {

/// Closest hits without a tree: every ray against every triangle of every instance, by the
/// library's own test of one triangle. What a tree answers must be the same in every bit.
std::vector<Found> brute_force(const Scene& scene, const trace::TraceView& view,
                               std::span<const Ray> rays);

}  // namespace regraft::test
