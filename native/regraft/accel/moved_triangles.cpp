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

void MovedTriangles::list(const Mesh& mesh) {
  begin_.assign(mesh.block_revisions.size() + 1, 0);
  for (const Triangle& corners : mesh.triangles)
    for_each_block(corners, [&](std::uint32_t block) { ++begin_[block + 1]; });
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  triangles_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for_each_block(mesh.triangles[t], [&](std::uint32_t block) { triangles_[next[block]++] = t; });
}

Motion MovedTriangles::take(const Mesh& mesh) {
  const std::uint32_t since = std::exchange(revision_, mesh.revision);
  const std::vector<std::uint32_t>& blocks = mesh.block_revisions;
  if (blocks.empty() || mesh.triangles.size() < smallest) return {};
  is_moved_.resize(blocks.size());
  std::size_t count = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) count += is_moved_[b] = blocks[b] > since;
  if (count * few_share > blocks.size()) return {};
  if (begin_.empty()) list(mesh);
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
