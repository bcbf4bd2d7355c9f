#pragma once

#include <gtest/gtest.h>

#include "trace/compare.h"
#include "trace/scene_oracle.h"

namespace regraft::test {

/// Those that need no key frames.
inline constexpr accel::Policy all_policies[] = {
    accel::Policy::automatic,       accel::Policy::refit,
    accel::Policy::rebuild,         accel::Policy::lm,
    accel::Policy::rtdeform,        accel::Policy::selective,
    accel::Policy::selective_rotate};

/// A scene with one accelerator, for tests that look at what single updates do.
struct Tended {
  Scene scene;
  accel::Accelerator accelerator;
  int width = 8;

  accel::UpdateStatistics update(const accel::UpdateOptions& options = {}) {
    const accel::UpdateStatistics statistics =
        accelerator.update(scene, scene.take_changes(), options, width, pool(2));
    EXPECT_EQ(accelerator.validate(scene), "");
    return statistics;
  }
  accel::UpdateStatistics update(accel::Policy policy,
                                 accel::Layout layout = accel::Layout::two_level) {
    accel::UpdateOptions options;
    options.policy = policy;
    options.layout = layout;
    return update(options);
  }

  /// What the accelerator finds otherwise than brute force over a scene built anew.
  std::string differences(std::uint64_t seed = 1, std::size_t count = 128) const {
    const std::vector<Ray> rays = nasty_rays(SceneOracle(scene), seed, count);
    return difference(accelerator.view(), width, rays, hits_anew(scene, rays));
  }
};

}  // namespace regraft::test
