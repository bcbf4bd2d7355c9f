#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/validate.h"
#include "trace/compare.h"

namespace regraft::test {

/// Boxes to build trees over, and the ids 0 … n−1.
struct Boxes {
  std::vector<Aabb> boxes;
  std::vector<std::uint32_t> ids;

  Boxes() = default;
  explicit Boxes(std::vector<Aabb> all) : boxes(std::move(all)), ids(boxes.size()) {
    std::iota(ids.begin(), ids.end(), 0u);
  }
  bvh::Bvh build(unsigned threads = 2, const bvh::BinnedSahBuilder::Config& config = {}) const {
    return bvh::BinnedSahBuilder::build(boxes, ids, config, pool(threads));
  }
  /// "" if `tree` is a tree over these boxes.
  std::string flaw(const bvh::Bvh& tree) const { return bvh::validate(tree, boxes, ids); }
};

inline Aabb cube(const Vec3d& center, double half) {
  return {Vec3(center - half), Vec3(center + half)};
}

/// Cubes of up to `size` anywhere in the cube of half width `half`.
inline Boxes random_boxes(std::size_t count, std::uint64_t seed, double half = 1.0,
                          double size = 0.1) {
  Random random(seed);
  std::vector<Aabb> boxes;
  for (std::size_t i = 0; i < count; ++i)
    boxes.push_back(cube(random.in_box(half), random.uniform(0.0, size)));
  return Boxes(std::move(boxes));
}

}  // namespace regraft::test
