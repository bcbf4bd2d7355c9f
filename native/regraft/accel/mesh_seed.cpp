#include "regraft/accel/mesh_seed.h"

#include <algorithm>
#include <numeric>

#include "regraft/accel/triangle_bounds.h"
#include "regraft/bvh/binned_sah_builder.h"

namespace regraft::accel {

namespace {

/// A run is halved when its box has more than this times the area of its triangles' boxes. A strip
/// of eight has about their sum, or a few times that where it bends.
constexpr double loose = 8.0;

/// Cuts a mesh into runs.
class Runs {
 public:
  explicit Runs(const Mesh& mesh) : mesh_(mesh) {
    const std::size_t expected = mesh.triangles.size() / MeshSeed::longest_run + 1;
    boxes.reserve(expected);
    runs.reserve(expected);
  }

  void add(std::uint32_t first, std::uint32_t count) {
    bvh::Box4 box[MeshSeed::longest_run];
    for (std::uint32_t i = 0; i < count; ++i) box[i] = fast_triangle_bounds(mesh_, first + i);
    add(box, first, count);
  }

  std::vector<Aabb> boxes;
  std::vector<MeshSeed::Run> runs;

 private:
  void add(const bvh::Box4* box, std::uint32_t first, std::uint32_t count) {
    bvh::Box4 all = box[0];
    double area = half_area(box[0].aabb());
    for (std::uint32_t i = 1; i < count; ++i) {
      all.extend(box[i]);
      area += half_area(box[i].aabb());
    }
    const Aabb aabb = all.aabb();
    if (aabb.empty()) return;
    if (count > 1 && half_area(aabb) > loose * area) {
      add(box, first, count / 2);
      add(box + count / 2, first + count / 2, count - count / 2);
      return;
    }
    boxes.push_back(aabb);
    runs.push_back({first, count});
  }

  const Mesh& mesh_;
};

}  // namespace

void MeshSeed::read(const Mesh& mesh, Executor& executor) {
  std::call_once(once_, [&] { build(mesh, executor); });
}

void MeshSeed::build(const Mesh& mesh, Executor& executor) {
  Runs found(mesh);
  const auto count = std::uint32_t(mesh.triangles.size());
  for (std::uint32_t first = 0; first < count; first += longest_run)
    found.add(first, std::min(longest_run, count - first));
  std::vector<std::uint32_t> ids(found.runs.size());
  std::iota(ids.begin(), ids.end(), 0u);
  bvh::BinnedSahBuilder::Config config;
  config.max_leaf = 1;
  bvh_ = bvh::BinnedSahBuilder::build(found.boxes, ids, config, executor);
  runs_ = std::move(found.runs);
  weights_.resize(bvh_.nodes.size());
  for (std::size_t n = bvh_.nodes.size(); n-- > 0;) {
    const bvh::Node& node = bvh_.nodes[n];
    if (n == 1) continue;
    weights_[n] = node.leaf() ? runs_[bvh_.prim_ids[node.first]].count
                              : weights_[node.first] + weights_[node.first + 1];
  }
}

std::size_t MeshSeed::bytes() const {
  return sizeof(MeshSeed) + bvh_.bytes() + runs_.capacity() * sizeof(Run) +
         weights_.capacity() * sizeof(std::uint32_t);
}

}  // namespace regraft::accel
