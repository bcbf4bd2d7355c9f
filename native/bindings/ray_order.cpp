#include "ray_order.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace regraft::bindings {

namespace {

/// Smaller batches stay in the cache however they are ordered.
constexpr std::size_t worth_sorting = 1 << 14;
constexpr std::size_t most_sorted = std::numeric_limits<std::uint32_t>::max();

// A key is the octant of the direction, then the origin's cell, then the direction's: measured,
// 4 and 8 bits an axis serve pictures and scattered rays alike.
constexpr int origin_bits = 4, direction_bits = 8;
constexpr int key_bits = 3 + 3 * origin_bits + 2 * direction_bits;

/// The cell of a coordinate in [0, 1], of 2^bits; numbers beyond are in the outer cells.
std::uint32_t cell(double x, int bits) {
  const double cells = double(1 << bits);
  return x > 0.0 ? static_cast<std::uint32_t>(std::min(x * cells, cells - 1.0)) : 0;
}

/// Two zero bits above each of the lowest four.
std::uint32_t spread3(std::uint32_t x) {
  x = (x | x << 4) & 0xC3;
  return (x | x << 2) & 0x249;
}

/// A zero bit above each of the lowest eight.
std::uint32_t spread2(std::uint32_t x) {
  x = (x | x << 4) & 0x0F0F;
  x = (x | x << 2) & 0x3333;
  return (x | x << 1) & 0x5555;
}

struct Cells {
  Vec3d low{std::numeric_limits<double>::infinity()};
  double scale = 0.0;  ///< to the unit cube
};

/// Of a sample: rays beyond it share the outer cells.
Cells origin_cells(const RayBatch& batch) {
  Cells cells;
  Vec3d high = -cells.low;
  for (std::size_t i = 0; i < batch.count; i += 64) {
    const Vec3d o = batch.origins.at(i);
    if (!std::isfinite(o.x + o.y + o.z)) continue;
    cells.low = glm::min(cells.low, o);
    high = glm::max(high, o);
  }
  const Vec3d size = high - cells.low;
  const double edge = std::max({size.x, size.y, size.z});
  if (edge > 0.0) cells.scale = 1.0 / edge;
  return cells;
}

std::uint32_t key_of(const Vec3d& origin, const Vec3d& direction, const Cells& cells) {
  std::uint32_t key = 0;
  for (int k = 0; k < 3; ++k) key |= static_cast<std::uint32_t>(std::signbit(direction[k])) << k;
  std::uint32_t place = 0;
  for (int k = 0; k < 3; ++k)
    place |= spread3(cell((origin[k] - cells.low[k]) * cells.scale, origin_bits)) << k;
  const Vec3d way = glm::abs(direction);
  const double sum = way.x + way.y + way.z;
  const std::uint32_t angle =
      spread2(cell(way.x / sum, direction_bits)) | spread2(cell(way.y / sum, direction_bits)) << 1;
  return (key << 3 * origin_bits | place) << 2 * direction_bits | angle;
}

}  // namespace

void sort_rays(RayBatch& batch, AlignedVector<bvh::KeyedId>& room, Executor& executor) {
  if (batch.count < worth_sorting || batch.count > most_sorted) return;
  room.resize(batch.count);
  const Cells cells = origin_cells(batch);
  executor.parallel_for(batch.count, 1 << 13, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      room[i] = {static_cast<std::uint32_t>(i),
                 key_of(batch.origins.at(i), batch.directions.at(i), cells)};
  });
  AlignedVector<bvh::KeyedId> scratch;
  bvh::radix_sort(room, scratch, key_bits, executor);
  batch.order = room;
}

}  // namespace regraft::bindings
