#include "regraft/bvh/binning.h"

namespace regraft::bvh {

namespace {

void sweep_axis(const BinSet& bins, int used, int axis, std::uint32_t size, Split& best) {
  double right_cost[max_bins];
  Box4 box;
  std::uint32_t count = 0;
  for (int i = used - 1; i > 0; --i) {
    box.extend(bins.box[axis][i].lo, bins.box[axis][i].hi);
    count += bins.count[axis][i];
    right_cost[i] = double(count) * box.half_area();
  }
  box = Box4{};
  count = 0;
  for (int i = 1; i < used; ++i) {
    box.extend(bins.box[axis][i - 1].lo, bins.box[axis][i - 1].hi);
    count += bins.count[axis][i - 1];
    // Nothing on one side: no split, and no box whose area could be asked for.
    if (count == 0) continue;
    if (count == size) return;
    const double cost = double(count) * box.half_area() + right_cost[i];
    if (cost < best.cost) best = {axis, i, cost};
  }
}

}  // namespace

Split best_split(const BinSet& bins, const BinMapping& mapping, std::uint32_t size) {
  Split best;
  for (int k = 0; k < 3; ++k)
    if (mapping.usable(k)) sweep_axis(bins, mapping.count(), k, size, best);
  return best;
}

}  // namespace regraft::bvh
