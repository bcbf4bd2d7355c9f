#include "regraft/bvh/share_out.h"

#include <algorithm>
#include <numeric>

#include "regraft/bvh/binning.h"

namespace regraft::bvh {

namespace {

template <typename F>
Sides divide(std::size_t count, const F& is_left) {
  Sides sides;
  for (std::uint32_t i = 0; i < count; ++i) sides[is_left(i) ? 0 : 1].push_back(i);
  return sides;
}

/// Area times number of both sides; infinite if one is empty.
double cost(std::span<const Aabb> boxes, const Sides& sides) {
  double sum = 0.0;
  for (const std::vector<std::uint32_t>& side : sides) {
    if (side.empty()) return std::numeric_limits<double>::infinity();
    Box4 box;
    for (const std::uint32_t i : side) box.extend(Box4(boxes[i]));
    sum += half_area(box.aabb()) * double(side.size());
  }
  return sum;
}

Sides by_bins(std::span<const Aabb> boxes) {
  std::vector<PrimRef> refs(boxes.size());
  Box4 centroids;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const Aabb& b = boxes[i];
    refs[i] = {{b.lo.x, b.lo.y, b.lo.z}, i, {b.hi.x, b.hi.y, b.hi.z}, 0};
    centroids.extend(refs[i].centroid4(), refs[i].centroid4());
  }
  const BinMapping mapping(centroids.aabb(), refs.size());
  BinSet bins(mapping.count());
  bins.add(mapping, refs);
  const Split best = best_split(bins, mapping, std::uint32_t(refs.size()));
  return divide(boxes.size(), [&](std::uint32_t i) {
    return best.axis >= 0 && mapping.is_below(refs[i], best.axis, best.bin);
  });
}

Sides by_halves(std::span<const Aabb> boxes, int axis) {
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto center = [&](std::uint32_t i) {
    return double(boxes[i].lo[axis]) + double(boxes[i].hi[axis]);
  };
  const auto middle = order.begin() + std::ptrdiff_t(order.size() / 2);
  std::nth_element(order.begin(), middle, order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return center(i) != center(j) ? center(i) < center(j) : i < j;
  });
  std::sort(order.begin(), middle);
  std::sort(middle, order.end());
  return {std::vector<std::uint32_t>(order.begin(), middle),
          std::vector<std::uint32_t>(middle, order.end())};
}

}  // namespace

Sides as_they_are(std::size_t count, std::size_t first) {
  return divide(count, [&](std::uint32_t i) { return i < first; });
}

Sides share_out(std::span<const Aabb> boxes, std::size_t first, const Plane& plane) {
  const auto center = [&](std::uint32_t i) {
    return 0.5 * double(boxes[i].lo[plane.axis]) + 0.5 * double(boxes[i].hi[plane.axis]);
  };
  Sides best = as_they_are(boxes.size(), first);
  double least = cost(boxes, best);
  const auto consider = [&](Sides sides) {
    const double tests = cost(boxes, sides);
    if (!(tests < least)) return;
    least = tests;
    best = std::move(sides);
  };
  consider(divide(boxes.size(), [&](std::uint32_t i) { return center(i) < plane.position; }));
  consider(by_bins(boxes));
  if (best[0].empty() || best[1].empty()) best = by_halves(boxes, plane.axis);
  return best;
}

}  // namespace regraft::bvh
