#include "regraft/bvh/morton_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "regraft/bvh/box4.h"
#include "regraft/bvh/radix_sort.h"
#include "regraft/bvh/subtrees.h"

namespace regraft::bvh {

namespace {

constexpr std::size_t chunk = 16384;
constexpr int axis_bits = 10;

Float4 centroid(const Aabb& box) {
  const Box4 b(box);
  // Halved before they are added, so that boxes near the largest float do not overflow.
  return Float4(0.5f) * b.lo + Float4(0.5f) * b.hi;
}

/// Two zero bits before each of the lowest ten.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000FFu;
  x = (x | x << 8) & 0x0300F00Fu;
  x = (x | x << 4) & 0x030C30C3u;
  return (x | x << 2) & 0x09249249u;
}

/// A grid of 2^10 cells along the longest axis, cubes all of them: boxes of the curve's pieces are
/// then about as wide as long. Cells stretched to the scene made trees of a flat sheet 10 % worse.
class MortonGrid {
 public:
  explicit MortonGrid(const Aabb& centroids) {
    float widest = 0.0f;
    for (int k = 0; k < 3; ++k) widest = std::max(widest, centroids.hi[k] - centroids.lo[k]);
    const float scale = float(1 << axis_bits) * 0.9999f / widest;
    // Denormal or overflowing extents have no grid: all is in cell 0.
    if (!(widest > 0.0f) || !std::isfinite(widest) || !std::isfinite(scale)) return;
    for (int k = 0; k < 3; ++k) {
      scale_[k] = scale;
      offset_[k] = centroids.lo[k];
    }
  }

  /// Codes of up to `block` primitives.
  static constexpr std::size_t block = 64;
  void encode(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids, KeyedId* out) const {
    float cell[3][block];
    for (std::size_t i = 0; i < ids.size(); ++i) {
      alignas(16) float t[4];
      ((centroid(boxes[ids[i]]) - Float4::load(offset_)) * Float4::load(scale_)).store(t);
      for (int k = 0; k < 3; ++k) cell[k][i] = t[k];
    }
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const auto x = std::uint32_t(std::int32_t(cell[0][i]));
      const auto y = std::uint32_t(std::int32_t(cell[1][i]));
      const auto z = std::uint32_t(std::int32_t(cell[2][i]));
      out[i] = {ids[i], spread(x) << 2 | spread(y) << 1 | spread(z)};
    }
  }

 private:
  alignas(16) float offset_[4]{};
  alignas(16) float scale_[4]{};
};

struct Range {
  std::uint32_t begin;
  std::uint32_t end;
  std::uint32_t depth;
  std::uint32_t size() const { return end - begin; }
};

class Build {
 public:
  Build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
        const MortonBuilder::Config& config, Executor& executor)
      : boxes_(boxes), ids_(ids), config_(config), executor_(executor) {}

  Bvh run() {
    Bvh bvh;
    if (ids_.empty()) return bvh;
    sort();
    build_top(bvh.nodes);
    const std::size_t top_size = bvh.nodes.size();
    bvh.prim_ids.resize(items_.size());
    parts_.resize(tasks_.size());
    executor_.parallel_for(tasks_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        parts_[i].node = tasks_[i].node;
        build_part(tasks_[i].range, parts_[i], bvh.prim_ids.data());
      }
    });
    splice(bvh, parts_, executor_);
    close_top(bvh, top_size);
    return bvh;
  }

 private:
  struct Task {
    std::uint32_t node;
    Range range;
  };

  void sort() {
    items_.resize(ids_.size());
    const MortonGrid grid(centroid_bounds());
    executor_.parallel_for(ids_.size(), chunk, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; i += MortonGrid::block)
        grid.encode(boxes_, ids_.subspan(i, std::min(MortonGrid::block, end - i)), &items_[i]);
    });
    AlignedVector<KeyedId> scratch;
    radix_sort(items_, scratch, 3 * axis_bits, executor_);
  }

  Aabb centroid_bounds() const {
    std::vector<Box4> parts((ids_.size() + chunk - 1) / chunk);
    executor_.parallel_for(ids_.size(), chunk, [&](std::size_t begin, std::size_t end) {
      Box4 box;
      for (std::size_t i = begin; i < end; ++i) {
        const Float4 c = centroid(boxes_[ids_[i]]);
        box.extend(c, c);
      }
      parts[begin / chunk] = box;
    });
    for (std::size_t i = 1; i < parts.size(); ++i) parts[0].extend(parts[i]);
    return parts[0].aabb();
  }

  /// Where the highest bit that differs within the range turns from 0 to 1.
  std::uint32_t split(const Range& range) const {
    const std::uint64_t bit = std::bit_floor(key(range.begin) ^ key(range.end - 1));
    std::uint32_t lo = range.begin, hi = range.end - 1;
    while (lo + 1 < hi) {
      const std::uint32_t middle = (lo + hi) / 2;
      ((key(middle) & bit) == 0 ? lo : hi) = middle;
    }
    return hi;
  }

  /// Splits down to the size of a task.
  void build_top(AlignedVector<Node>& nodes) {
    const std::size_t task_size = std::max<std::size_t>(4096, ids_.size() / 64);
    start_tree(nodes);
    std::vector<Task> open{{0, {0, std::uint32_t(ids_.size()), 0}}};
    while (!open.empty()) {
      const Task item = open.back();
      open.pop_back();
      if (item.range.size() <= task_size) {
        tasks_.push_back(item);
        continue;
      }
      const std::uint32_t first = make_inner(nodes, item.node);
      const std::uint32_t middle = split(item.range);
      open.push_back({first + 1, {middle, item.range.end, item.range.depth + 1}});
      open.push_back({first, {item.range.begin, middle, item.range.depth + 1}});
    }
  }

  /// What will be a node once its sibling is known: children lie side by side.
  struct Open {
    Box4 box;
    std::uint64_t gap;  ///< highest bit: where the curve turns between this and what follows
    std::uint32_t first;
    std::uint32_t prims;
    std::uint32_t height;
  };

  /// Keys made unique: what is equal is split by position.
  std::uint64_t key(std::uint32_t i) const { return std::uint64_t(items_[i].key) << 32 | i; }

  /// One walk along the curve, with a stack of subtrees whose siblings are still to come: a
  /// subtree is joined to the one before it as soon as the gap after it is the wider one (Apetrei,
  /// Fast and Simple Agglomerative LBVH Construction, CGVC 2014, without its atomics).
  void build_part(const Range& range, Subtree& part, std::uint32_t* prim_ids) const {
    part.nodes.reserve(2 + range.size());
    start_tree(part.nodes);
    Open stack[max_depth + 4];
    std::size_t top = 0;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      prefetch(i + 16);
      const std::uint32_t id = items_[i].id;
      prim_ids[i] = id;
      const bool last = i + 1 == range.end;
      const std::uint64_t gap = last ? ~std::uint64_t(0) : key(i) ^ key(i + 1);
      Open open{Box4(boxes_[id]), gap, i, 1, 0};
      while (top > 0 && stack[top - 1].gap < gap) join(stack[--top], open, part);
      stack[top++] = open;
    }
    write(stack[0], part.nodes[0]);
    part.depth = range.depth + stack[0].height;
  }

  void prefetch(std::uint32_t i) const {
    if (i < items_.size()) __builtin_prefetch(&boxes_[items_[i].id]);
  }

  /// Adds `left` to `right`, the subtree after it.
  void join(const Open& left, Open& right, Subtree& part) const {
    if (left.prims + right.prims > config_.max_leaf) {
      const auto first = std::uint32_t(part.nodes.size());
      part.nodes.resize(first + 2);
      write(left, part.nodes[first]);
      write(right, part.nodes[first + 1]);
      right.first = first;
      right.height = 1 + std::max(left.height, right.height);
    } else {
      right.first = left.first;
    }
    right.prims += left.prims;
    right.box.extend(left.box);
  }

  void write(const Open& open, Node& node) const {
    // Whole registers: what is written beyond the corner is the number that follows it.
    open.box.lo.store(reinterpret_cast<float*>(&node));
    open.box.hi.store(reinterpret_cast<float*>(&node) + 4);
    node.first = open.first;
    node.count = open.prims <= config_.max_leaf ? open.prims : 0;
  }

  std::span<const Aabb> boxes_;
  std::span<const std::uint32_t> ids_;
  const MortonBuilder::Config& config_;
  Executor& executor_;
  AlignedVector<KeyedId> items_;
  std::vector<Task> tasks_;
  std::vector<Subtree> parts_;
};

}  // namespace

Bvh MortonBuilder::build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
                         const Config& config, Executor& executor) {
  return Build(boxes, ids, config, executor).run();
}

}  // namespace regraft::bvh
