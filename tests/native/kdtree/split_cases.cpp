#include "kdtree/split_cases.h"

#include <random>

namespace regraft::test {
namespace {

using kdtree::SplitEntry;

class Maker {
 public:
  explicit Maker(std::uint32_t seed) : random_(seed) {}
  float uniform(float lo, float hi) {
    return std::uniform_real_distribution<float>(lo, hi)(random_);
  }
  Vec3 point(float lo, float hi) { return {uniform(lo, hi), uniform(lo, hi), uniform(lo, hi)}; }
  double weight() { return double(std::uniform_int_distribution<int>(1, 20)(random_)); }

  Aabb around(const Vec3& centre, float size) {
    const Vec3 half = point(0.0f, size);
    return {centre - half, centre + half};
  }
  Aabb box(int kind, std::size_t index) {
    const Vec3 anywhere = point(0.0f, 10.0f);
    switch (kind) {
      case 1:
        return around(Vec3(3.0f) + point(-1.0f, 1.0f) * point(0.0f, 1.0f), 0.05f);
      case 2: {
        const Vec3 cell = glm::floor(anywhere);
        return {cell, cell + Vec3(1.0f)};
      }
      case 3:
        return index == 0 ? Aabb{Vec3(0.1f), Vec3(9.9f)} : around(anywhere, 0.02f);
      case 4:
        return index == 0 ? Aabb{Vec3(0.0f), Vec3(10.0f)}
                          : around(Vec3(7) + 1e-5f * anywhere, 1e-6f);
      case 5: {
        Aabb flat = around(anywhere, 0.5f);
        const int k = int(index % 3);
        flat.lo[k] = flat.hi[k] = glm::floor(anywhere[k]);
        return flat;
      }
      case 6:
        return {Vec3(2.0f), Vec3(3.0f)};
      case 7:
        return around(anywhere, 8.0f);
      default:
        return around(anywhere, 0.3f);
    }
  }

 private:
  std::mt19937 random_;
};

}  // namespace

SplitCase split_case(int kind, std::size_t count, std::uint32_t seed) {
  Maker make(seed);
  SplitCase c;
  c.voxel = {Vec3(0.0f), Vec3(10.0f)};
  for (std::size_t i = 0; i < count; ++i) {
    Aabb box = make.box(kind, i);
    if (kind != 7) box = kdtree::clipped(box, c.voxel);
    const double weight = kind == 0 ? 1.0 : make.weight();
    if (!kdtree::clipped(box, c.voxel).empty()) c.entries.push_back({box, weight});
  }
  return c;
}

double brute_force_cost(const SplitCase& c, const kdtree::ChildProbability& probability,
                        const kdtree::SplitCost& cost, int axis, float position) {
  kdtree::Sides sides;
  for (const SplitEntry& entry : c.entries) {
    const float lo = entry.box.lo[axis];
    const float hi = entry.box.hi[axis];
    if (lo < position) sides.left += entry.weight;
    if (hi > position) sides.right += entry.weight;
    if (lo == position && hi == position) sides.flat += entry.weight;
  }
  return kdtree::plane_cost(cost, probability.at(axis, position), sides);
}

kdtree::Split brute_force_split(const SplitCase& c, const kdtree::ChildProbability& probability,
                                const kdtree::SplitCost& cost) {
  kdtree::Split best;
  double leaf = 0.0;
  for (const SplitEntry& entry : c.entries) leaf += cost.intersect * entry.weight;
  for (int axis = 0; axis < 3; ++axis)
    for (const SplitEntry& entry : c.entries)
      for (const float position : {entry.box.lo[axis], entry.box.hi[axis]}) {
        if (!(position > c.voxel.lo[axis] && position < c.voxel.hi[axis])) continue;
        if (!(entry.weight > 0.0)) continue;
        const kdtree::ChildProbability::Pair p = probability.at(axis, position);
        const double total = brute_force_cost(c, probability, cost, axis, position);
        kdtree::offer(best, axis, position, total, p.left < p.right);
      }
  if (!(best.cost < leaf)) best.axis = -1;
  return best;
}

}  // namespace regraft::test
