#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "render/stage.h"

namespace regraft::render {
namespace {

using test::sized;
using test::Stage;

/// A picture that takes long: it is never finished in these tests.
RenderSettings endless() {
  RenderSettings settings = sized(512, 512, Shading::occlusion);
  settings.samples = 4096;
  settings.passes = {"combined", "depth"};
  return settings;
}

Stage& furnished(Stage& stage) {
  stage.add(test::square(5.0f));
  stage.add(test::ball(32), test::placed({0.0, 0.0, 1.0}));
  return stage;
}

TEST(Cancel, AFrameCancelledAtOnceIsTransparentAndInfinitelyFar) {
  Stage stage;
  RenderSettings settings = endless();
  settings.poll = [](double) { return false; };
  const Frame frame = furnished(stage).picture(test::from_above(4.0), settings);
  EXPECT_TRUE(frame.cancelled);
  for (const float value : frame.passes.at("combined").pixels) ASSERT_EQ(value, 0.0f);
  for (const float value : frame.passes.at("depth").pixels)
    ASSERT_EQ(value, std::numeric_limits<float>::infinity());
}

TEST(Cancel, WorkersStopInTheMiddleOfATile) {
  // Were a tile's 4,096 samples finished first, this would take minutes and time out.
  Stage stage;
  RenderSettings settings = endless();
  int calls = 0;
  settings.poll = [&](double) { return ++calls < 3; };
  const Frame frame = furnished(stage).picture(test::from_above(4.0), settings);
  EXPECT_TRUE(frame.cancelled);
  EXPECT_EQ(calls, 3);
  EXPECT_GT(frame.statistics.rays_primary, 0u);
}

TEST(Cancel, FinishedTilesStayAndTheRestIsEmpty) {
  Stage stage;
  RenderSettings settings = endless();
  settings.samples = 16;
  settings.poll = [](double fraction) { return fraction == 0.0; };
  const Frame part = furnished(stage).picture(test::from_above(4.0), settings);
  settings.poll = nullptr;
  const Frame whole = stage.renderer.render(test::from_above(4.0), settings);
  ASSERT_TRUE(part.cancelled);
  std::size_t kept = 0, empty = 0;
  for (std::uint32_t y = 0; y < 512; y += 8)
    for (std::uint32_t x = 0; x < 512; x += 8) {
      const bool there = part.passes.at("combined").pixel(x, y)[3] > 0.0f;
      ++(there ? kept : empty);
      for (std::uint32_t i = 0; i < 64; ++i) {
        const float* got = part.passes.at("combined").pixel(x + i % 8, y + i / 8);
        const float* full = whole.passes.at("combined").pixel(x + i % 8, y + i / 8);
        for (int c = 0; c < 4; ++c) ASSERT_EQ(got[c], there ? full[c] : 0.0f);
      }
    }
  EXPECT_GT(kept, 0u);
  EXPECT_GT(empty, 0u);
}

TEST(Cancel, AnExceptionOfThePollComesThrough) {
  Stage stage;
  RenderSettings settings = endless();
  settings.poll = [](double) -> bool { throw std::runtime_error("interrupted"); };
  EXPECT_THROW(furnished(stage).picture(test::from_above(4.0), settings), std::runtime_error);
  settings = sized(16, 16);
  EXPECT_FALSE(stage.renderer.render(test::from_above(4.0), settings).cancelled);
}

TEST(Cancel, ProgressNeverFallsAndStaysWithinItsBounds) {
  Stage stage;
  RenderSettings settings = sized(256, 256, Shading::occlusion);
  settings.samples = 4;
  double last = 0.0;
  bool in_order = true;
  settings.poll = [&](double fraction) {
    in_order &= fraction >= last && fraction <= 1.0;
    last = fraction;
    return true;
  };
  EXPECT_FALSE(furnished(stage).picture(test::from_above(4.0), settings).cancelled);
  EXPECT_TRUE(in_order);
}

}  // namespace
}  // namespace regraft::render
