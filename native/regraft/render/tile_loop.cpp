#include "regraft/render/tile_loop.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <limits>

namespace regraft::render {

namespace {

using shade::Image;
using shade::lane_count;
using shade::Planes;

std::uint32_t tiles_over(std::uint32_t begin, std::uint32_t end) {
  return (end + 7) / 8 - begin / 8;
}

/// Tiles along a block's edge: few enough that handing them out costs nothing, and that threads
/// finish together.
std::uint32_t choose_block_edge(const shade::ShadingSettings& settings) {
  const bool occlusion = settings.shading == shade::Shading::occlusion;
  const std::uint32_t rays = std::max(settings.samples, occlusion ? shade::occlusion_rays : 1u);
  return rays < 4 ? 4 : rays < 16 ? 2 : 1;
}

}  // namespace

TileLoop::TileLoop(const shade::PictureShading& picture, const shade::Raster& raster)
    : picture_(picture),
      raster_(raster),
      columns_(tiles_over(raster.x0, raster.x1)),
      rows_(tiles_over(raster.y0, raster.y1)),
      block_edge_(choose_block_edge(picture.settings)),
      block_columns_((columns_ + block_edge_ - 1) / block_edge_),
      block_rows_((rows_ + block_edge_ - 1) / block_edge_),
      finished_(std::size_t(columns_) * rows_, 0) {
  make_images();
}

void TileLoop::make_images() {
  const Planes& wanted = picture_.settings.planes;
  const std::uint32_t width = raster_.x1 - raster_.x0;
  const std::uint32_t height = raster_.y1 - raster_.y0;
  if (wanted.combined) combined_ = Image(width, height, 4);
  if (wanted.depth) depth_ = Image(width, height, 1);
  if (wanted.normal) normal_ = Image(width, height, 3);
  if (wanted.object_index) object_index_ = Image(width, height, 1);
  if (wanted.cost) cost_ = Image(width, height, 1);
}

shade::Tile TileLoop::tile(std::size_t index) const {
  const auto column = std::uint32_t(index % columns_);
  const auto row = std::uint32_t(index / columns_);
  return shade::make_tile(raster_, 8 * (raster_.x0 / 8 + column), 8 * (raster_.y0 / 8 + row));
}

bool TileLoop::run(Executor& executor, const std::function<bool(double)>& poll) {
  const auto poll_once = [&] {
    try {
      if (!poll || poll(double(finished_count_.load()) / double(finished_.size()))) return true;
    } catch (...) {
      cancelled_.store(true);
      throw;
    }
    cancelled_.store(true);
    return false;
  };
  executor.parallel_for_polled(
      std::size_t(block_columns_) * block_rows_, [&](std::size_t i) { render_block(i); },
      poll_once);
  if (finished_count_.load() != finished_.size()) clear_unfinished();
  return !cancelled_.load();
}

void TileLoop::render_block(std::size_t block) {
  const auto start = std::chrono::steady_clock::now();
  const std::uint32_t column0 = std::uint32_t(block % block_columns_) * block_edge_;
  const std::uint32_t row0 = std::uint32_t(block / block_columns_) * block_edge_;
  shade::TileShader shader(picture_, cancelled_);
  shade::TilePixels pixels;
  for (std::uint32_t row = row0; row < std::min(row0 + block_edge_, rows_); ++row)
    for (std::uint32_t column = column0; column < std::min(column0 + block_edge_, columns_);
         ++column) {
      const std::size_t index = std::size_t(row) * columns_ + column;
      const shade::Tile here = tile(index);
      if (!shader.render(here, pixels)) continue;
      store(here, pixels);
      finished_[index] = 1;
      finished_count_.fetch_add(1, std::memory_order_relaxed);
    }
  const std::lock_guard lock(tally_mutex_);
  tally_.rays += shader.tally();
  tally_.met_smooth |= shader.met_smooth();
  tally_.total_ns += std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count();
}

namespace {

/// Writes the lanes of a tile into a plane, a row of pixels at a time.
template <std::size_t Channels>
void store_plane(const shade::Tile& tile, const shade::Raster& raster,
                 const std::array<const shade::FloatLanes*, Channels>& from, Image& to) {
  for (std::uint32_t row = 0; row < 8; ++row) {
    const auto columns = std::uint32_t(tile.active >> (8 * row) & 0xFFu);
    if (columns == 0) continue;
    const auto first = std::uint32_t(std::countr_zero(columns));
    const auto count = std::uint32_t(std::popcount(columns));
    float* pixel = to.pixel(tile.x0 + first - raster.x0, tile.y0 + row - raster.y0);
    for (std::uint32_t x = 0; x < count; ++x)
      for (std::size_t c = 0; c < Channels; ++c)
        pixel[Channels * x + c] = (*from[c])[8 * row + first + x];
  }
}

}  // namespace

void TileLoop::store(const shade::Tile& tile, const shade::TilePixels& p) {
  const Planes& wanted = picture_.settings.planes;
  if (wanted.combined)
    store_plane<4>(tile, raster_, {&p.combined[0], &p.combined[1], &p.combined[2], &p.combined[3]},
                   combined_);
  if (wanted.normal)
    store_plane<3>(tile, raster_, {&p.normal.x, &p.normal.y, &p.normal.z}, normal_);
  if (wanted.depth) store_plane<1>(tile, raster_, {&p.depth}, depth_);
  if (wanted.object_index) store_plane<1>(tile, raster_, {&p.object_index}, object_index_);
  if (wanted.cost) store_plane<1>(tile, raster_, {&p.cost}, cost_);
}

/// Tiles that were not finished show nothing: transparent, infinitely far.
void TileLoop::clear_unfinished() {
  shade::TilePixels nothing{};
  nothing.depth.fill(std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < finished_.size(); ++i)
    if (finished_[i] == 0) store(tile(i), nothing);
}

std::map<std::string, Image> TileLoop::take_images() {
  const Planes& wanted = picture_.settings.planes;
  std::map<std::string, Image> images;
  if (wanted.combined) images.emplace("combined", std::move(combined_));
  if (wanted.depth) images.emplace("depth", std::move(depth_));
  if (wanted.normal) images.emplace("normal", std::move(normal_));
  if (wanted.object_index) images.emplace("object_index", std::move(object_index_));
  if (wanted.cost) images.emplace("cost", std::move(cost_));
  return images;
}

}  // namespace regraft::render
