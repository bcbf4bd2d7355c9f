#include "regraft/shade/sampler.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace regraft::shade {
namespace {

struct Point {
  float u, v;
};

/// All points of some lanes of a tile.
std::vector<Point> points_of(const Sampler& sampler, std::uint32_t samples,
                             const std::vector<std::uint32_t>& lanes, std::uint32_t dimension,
                             std::uint32_t x0 = 40, std::uint32_t y0 = 16) {
  std::vector<Point> points;
  PointLanes tile;
  for (std::uint32_t s = 0; s < samples; ++s) {
    sampler.points(x0, y0, s, dimension, tile);
    for (const std::uint32_t lane : lanes) points.push_back({tile.u[lane], tile.v[lane]});
  }
  return points;
}

/// True if each cell of the grid of `columns` × `rows` holds equally many points.
bool even(const std::vector<Point>& points, std::uint32_t columns, std::uint32_t rows) {
  std::vector<std::size_t> cells(std::size_t(columns) * rows, 0);
  for (const Point& p : points)
    ++cells[std::size_t(p.v * float(rows)) * columns + std::size_t(p.u * float(columns))];
  for (const std::size_t count : cells)
    if (count * cells.size() != points.size()) return false;
  return true;
}

TEST(Sampler, APixelsPointsAreANet) {
  // (0, 4, 2)-net: one of sixteen points in every elementary interval of area 1/16.
  const Sampler sampler(7, 16);
  for (const std::uint32_t dimension : {0u, 1u, 9u})
    for (std::uint32_t lane = 0; lane < lane_count; ++lane) {
      const auto points = points_of(sampler, 16, {lane}, dimension);
      for (std::uint32_t columns = 1; columns <= 16; columns *= 2)
        EXPECT_TRUE(even(points, columns, 16 / columns)) << lane << ", " << columns << " columns";
    }
}

TEST(Sampler, NeighboursShareTheSquareBetweenThem) {
  const Sampler sampler(3, 4);
  for (const std::vector<std::uint32_t>& lanes :
       {std::vector<std::uint32_t>{0, 1, 8, 9}, {2, 3, 10, 11}, {36, 37, 44, 45}}) {
    const auto points = points_of(sampler, 4, lanes, 0);
    for (std::uint32_t columns = 1; columns <= 16; columns *= 2)
      EXPECT_TRUE(even(points, columns, 16 / columns));
  }
}

TEST(Sampler, WholeTilesAreNetsInOneDimensionToo) {
  const Sampler sampler(3, 1);
  FloatLanes numbers;
  sampler.numbers(8, 24, 0, 2, numbers);
  std::vector<Point> points;
  for (const float x : numbers.value) points.push_back({x, 0.0f});
  EXPECT_TRUE(even(points, 64, 1));
}

TEST(Sampler, AnyNumberOfSamplesStaysInTheUnitSquareAndDiffers) {
  for (const std::uint32_t samples : {1u, 3u, 7u, 100u}) {
    std::set<std::pair<float, float>> seen;
    for (const Point& p : points_of(Sampler(1, samples), samples, {5}, 0)) {
      EXPECT_TRUE(p.u >= 0.0f && p.u < 1.0f && p.v >= 0.0f && p.v < 1.0f);
      seen.insert({p.u, p.v});
    }
    EXPECT_EQ(seen.size(), samples);
  }
}

bool differ(const std::vector<Point>& a, const std::vector<Point>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].u == b[i].u || a[i].v == b[i].v) return false;
  return true;
}

TEST(Sampler, SeedsDimensionsAndTilesAreIndependent) {
  const std::vector<std::uint32_t> lanes{0, 17, 63};
  const auto base = points_of(Sampler(1, 4), 4, lanes, 0);
  EXPECT_TRUE(differ(base, points_of(Sampler(2, 4), 4, lanes, 0)));
  EXPECT_TRUE(differ(base, points_of(Sampler(1ull << 32 | 1, 4), 4, lanes, 0)));
  EXPECT_TRUE(differ(base, points_of(Sampler(1, 4), 4, lanes, 1)));
  EXPECT_TRUE(differ(base, points_of(Sampler(1, 4), 4, lanes, 0, 48, 16)));
}

TEST(Sampler, DimensionsAreNotCorrelated) {
  // Were the index not shuffled, halves in one dimension would be halves in the other.
  const auto a = points_of(Sampler(5, 64), 64, {0}, 0);
  const auto b = points_of(Sampler(5, 64), 64, {0}, 1);
  std::size_t together = 0;
  for (std::size_t i = 0; i < a.size(); ++i) together += (a[i].u < 0.5f) == (b[i].u < 0.5f);
  EXPECT_GT(together, 16u);
  EXPECT_LT(together, 48u);
}

TEST(Sampler, HugeSampleCountsAreLegal) {
  PointLanes tile;
  Sampler(0, 0xFFFFFFFFu).points(65528, 65528, 0xFFFFFFFEu, 0, tile);
  EXPECT_GE(tile.u[63], 0.0f);
  EXPECT_LT(tile.u[63], 1.0f);
}

}  // namespace
}  // namespace regraft::shade
