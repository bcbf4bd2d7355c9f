#include "regraft/bvh/binning.h"

namespace regraft::bvh {

namespace {

void sweep_axis(const BinSet& bins, int used, int axis, Split& best) {
  std::array<double, max_bins> right_cost;
  std::array<Aabb, max_bins> right_box;
  Box4 box;
  std::uint64_t count = 0;
  for (int i = used - 1; i > 0; --i) {
    box.extend(bins.box[axis][i].lo, bins.box[axis][i].hi);
    count += bins.count[axis][i];
    right_box[std::size_t(i)] = box.aabb();
    right_cost[std::size_t(i)] =
        count == 0 ? -1.0 : half_area(right_box[std::size_t(i)]) * double(count);
  }
  box = Box4{};
  count = 0;
  for (int i = 1; i < used; ++i) {
    box.extend(bins.box[axis][i - 1].lo, bins.box[axis][i - 1].hi);
    count += bins.count[axis][i - 1];
    if (count == 0 || right_cost[std::size_t(i)] < 0.0) continue;
    const Aabb left = box.aabb();
    const double cost = half_area(left) * double(count) + right_cost[std::size_t(i)];
    if (cost < best.cost) best = {axis, i, cost, left, right_box[std::size_t(i)]};
  }
}

}  // namespace

Split best_split(const BinSet& bins, const BinMapping& mapping) {
  Split best;
  for (int k = 0; k < 3; ++k)
    if (mapping.usable(k)) sweep_axis(bins, mapping.count(), k, best);
  return best;
}

}  // namespace regraft::bvh
