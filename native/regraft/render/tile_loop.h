#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "regraft/core/executor.h"
#include "regraft/shade/image.h"
#include "regraft/shade/preview_shading.h"

namespace regraft::render {

/// What rendering the tiles took.
struct LoopTally {
  shade::RayTally rays;
  std::int64_t total_ns = 0;  ///< of all workers together
  bool met_smooth = false;
};

/// Renders the tiles of a picture on all threads. A pixel depends on nothing but its own place, so
/// the picture is the same however tiles are handed out.
class TileLoop {
 public:
  TileLoop(const shade::PictureShading& picture, const shade::Raster& raster);

  /// Renders everything. `poll(fraction)` is called on this thread about every 20 ms; when it
  /// returns false or throws, workers stop at their next sample of a tile, and tiles that were
  /// not finished are left transparent.
  /// @return false if it was cancelled.
  bool run(Executor& executor, const std::function<bool(double)>& poll);

  /// The finished planes by name of the pass; to be taken once.
  std::map<std::string, shade::Image> take_images();
  const LoopTally& tally() const { return tally_; }

 private:
  void make_images();
  void render_block(std::size_t block);
  void store(const shade::Tile& tile, const shade::TilePixels& pixels);
  void clear_unfinished();
  shade::Tile tile(std::size_t index) const;

  const shade::PictureShading& picture_;
  shade::Raster raster_;
  std::uint32_t columns_, rows_;  ///< tiles
  std::uint32_t block_edge_;      ///< tiles
  std::uint32_t block_columns_, block_rows_;
  shade::Image combined_, depth_, normal_, object_index_, cost_;
  std::vector<std::uint8_t> finished_;  ///< by tile
  std::atomic<std::size_t> finished_count_{0};
  std::atomic<bool> cancelled_{false};
  std::mutex tally_mutex_;
  LoopTally tally_;
};

}  // namespace regraft::render
