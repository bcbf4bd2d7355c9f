#include "regraft/accel/moved_triangles.h"

#include <algorithm>
#include <utility>

namespace regraft::accel {

namespace {

/// Smaller meshes are followed as a whole.
constexpr std::size_t smallest = 512;

/// Calls `found` with each block of vertices that a triangle hangs on, once.
template <typename F>
void for_each_block(const Triangle& corners, const F& found) {
  const std::uint32_t a = corners.x / vertex_block, b = corners.y / vertex_block,
                      c = corners.z / vertex_block;
  found(a);
  if (b != a) found(b);
  if (c != a && c != b) found(c);
}

}  // namespace

void MovedTriangles::reset(const Mesh& mesh) {
  *this = {};
  revision_ = mesh.revision;
}

/// Sorts by counting: each run of triangles counts for itself, and so knows where its own go.
void MovedTriangles::list(const Mesh& mesh, Executor& executor) {
  constexpr std::size_t runs = 16;
  const std::size_t length = mesh.triangles.size() / runs + 1;
  std::vector<std::vector<std::uint32_t>> next(runs);
  const auto for_each_run = [&](const auto& body) {
    executor.parallel_for(runs, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t run = first; run < last; ++run) {
        const std::size_t end = std::min((run + 1) * length, mesh.triangles.size());
        for (std::size_t t = run * length; t < end; ++t)
          for_each_block(mesh.triangles[t],
                         [&](std::uint32_t block) { body(next[run][block], std::uint32_t(t)); });
      }
    });
  };
  begin_.assign(mesh.block_revisions.size() + 1, 0);
  for (std::vector<std::uint32_t>& counts : next) counts.assign(begin_.size() - 1, 0);
  for_each_run([](std::uint32_t& count, std::uint32_t) { ++count; });
  std::uint32_t sum = 0;
  for (std::size_t block = 0; block + 1 < begin_.size(); ++block) {
    begin_[block] = sum;
    for (std::vector<std::uint32_t>& counts : next) sum += std::exchange(counts[block], sum);
  }
  begin_.back() = sum;
  triangles_.resize(sum);
  for_each_run([&](std::uint32_t& place, std::uint32_t t) { triangles_[place++] = t; });
}

Motion MovedTriangles::take(const Mesh& mesh, Executor& executor) {
  const std::uint32_t since = std::exchange(revision_, mesh.revision);
  const std::vector<std::uint32_t>& blocks = mesh.block_revisions;
  if (blocks.empty() || mesh.triangles.size() < smallest) return {};
  is_moved_.resize(blocks.size());
  std::size_t count = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) count += is_moved_[b] = blocks[b] > since;
  if (count * few_share > blocks.size()) return {};
  if (begin_.empty()) list(mesh, executor);
  moved_.clear();
  for (std::uint32_t b = 0; b < blocks.size(); ++b) {
    if (is_moved_[b] == 0) continue;
    for (std::uint32_t i = begin_[b]; i < begin_[b + 1]; ++i) {
      // Of the blocks that a triangle hangs on the lowest that moved tells of it.
      std::uint32_t lowest = b;
      for_each_block(mesh.triangles[triangles_[i]], [&](std::uint32_t block) {
        if (block < lowest && is_moved_[block] != 0) lowest = block;
      });
      if (lowest == b) moved_.push_back(triangles_[i]);
    }
  }
  if (moved_.size() * few_share > mesh.triangles.size()) return {};
  return {false, moved_};
}

std::size_t MovedTriangles::bytes() const {
  return (triangles_.capacity() + begin_.capacity() + moved_.capacity()) * sizeof(std::uint32_t) +
         is_moved_.capacity();
}

}  // namespace regraft::accel
