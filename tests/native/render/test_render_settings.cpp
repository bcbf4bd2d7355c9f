#include "regraft/render/render_settings.h"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

namespace regraft::render {
namespace {

RenderSettings valid() {
  RenderSettings s;
  s.width = 20;
  s.height = 10;
  return s;
}

/// What checking complains of, after `change`; "" if of nothing.
std::string complaint(const std::function<void(RenderSettings&)>& change) {
  RenderSettings s = valid();
  change(s);
  try {
    checked_raster(s);
    checked_shading(s);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

bool names(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

TEST(RenderSettings, NothingIsWrongWithTheDefaultsButTheSize) {
  EXPECT_EQ(complaint([](RenderSettings&) {}), "");
  EXPECT_THROW(checked_raster(RenderSettings{}), std::invalid_argument);
}

TEST(RenderSettings, SizesOutOfRangeAreNamed) {
  EXPECT_TRUE(names(complaint([](auto& s) { s.width = 0; }), "width"));
  EXPECT_TRUE(names(complaint([](auto& s) { s.height = 0; }), "height"));
  EXPECT_TRUE(names(complaint([](auto& s) { s.width = max_side + 1; }), "width"));
  EXPECT_TRUE(names(complaint([](auto& s) { s.samples = 0; }), "samples"));
  EXPECT_TRUE(names(complaint([](auto& s) { s.samples = max_samples + 1; }), "samples"));
}

TEST(RenderSettings, UnknownPassesAreNamedAndTheKnownListed) {
  const std::string text = complaint([](auto& s) { s.passes = {"combined", "colour"}; });
  EXPECT_TRUE(names(text, "\"colour\""));
  for (const char* known : {"combined", "depth", "normal", "object_index", "cost"})
    EXPECT_TRUE(names(text, known)) << known;
  EXPECT_TRUE(names(complaint([](auto& s) { s.passes.clear(); }), "pass"));
}

TEST(RenderSettings, EachPassSetsItsOwnPlane) {
  RenderSettings s = valid();
  s.passes = {"depth", "cost"};
  const shade::Planes planes = checked_shading(s).planes;
  EXPECT_TRUE(planes.depth && planes.cost);
  EXPECT_FALSE(planes.combined || planes.normal || planes.object_index);
}

TEST(RenderSettings, RegionsMustLieInTheImageAndHoldAPixel) {
  using Region = std::array<std::uint32_t, 4>;
  for (const Region& region : {Region{5, 0, 5, 10}, Region{0, 6, 20, 6}, Region{0, 0, 21, 10},
                               Region{0, 0, 20, 11}, Region{9, 0, 3, 10}})
    EXPECT_TRUE(names(complaint([&](auto& s) { s.region = region; }), "region"));
  EXPECT_EQ(complaint([](auto& s) { s.region = {19, 9, 20, 10}; }), "");
}

TEST(RenderSettings, NoRegionMeansTheWholeImage) {
  const shade::Raster raster = checked_raster(valid());
  EXPECT_EQ(raster.x0, 0u);
  EXPECT_EQ(raster.y0, 0u);
  EXPECT_EQ(raster.x1, 20u);
  EXPECT_EQ(raster.y1, 10u);
}

TEST(RenderSettings, ShadingNamesGoBothWays) {
  for (const Shading shading :
       {Shading::clay, Shading::occlusion, Shading::direct, Shading::reflection, Shading::cost})
    EXPECT_EQ(parse_shading(name(shading)), shading);
  EXPECT_THROW(parse_shading("toon"), std::invalid_argument);
  EXPECT_THROW(parse_shading(""), std::invalid_argument);
}

}  // namespace
}  // namespace regraft::render
