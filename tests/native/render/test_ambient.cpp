#include <gtest/gtest.h>

#include "stage.h"

namespace regraft::render {
namespace {

using test::Stage;

/// Red of a white square seen from `eye`, under a light that gives nothing, in a world of 0.5.
float ambient(const Vec3d& eye) {
  Stage stage;
  stage.renderer.scene().set_world(Vec3(0.5f));
  stage.light(test::sun({0.0, 0.0, 1.0}, 0.0f));
  stage.renderer.scene().set_materials({test::plain(Vec3(1.0f))});
  stage.add(test::square(1.0f), Mat4d(1.0), {0});
  return test::red(stage.picture(test::perspective(eye, Vec3d(0.0)), test::sized(3, 3)), 1, 1);
}

TEST(Ambient, AWhiteSurfaceIsDarkerThanTheWorldAndDarkerStillFromBelow) {
  EXPECT_NEAR(ambient({0.0, 0.0, 2.0}), 0.5f * 0.8f, 1e-3f);
  EXPECT_NEAR(ambient({0.0, 0.0, -2.0}), 0.5f * 0.3f, 1e-3f);
}

}  // namespace
}  // namespace regraft::render
