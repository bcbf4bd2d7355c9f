#include "regraft/bvh/binned_sah_builder.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "regraft/bvh/binning.h"
#include "regraft/bvh/part_few.h"
#include "regraft/bvh/partition.h"
#include "regraft/bvh/subtrees.h"

namespace regraft::bvh {

namespace {

/// Ranges above this are binned and partitioned by all threads, in pieces of `chunk`.
constexpr std::size_t parallel_size = 65536;
constexpr std::size_t chunk = 16384;

struct Range {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::uint32_t depth = 0;
  std::uint32_t buffer = 0;  ///< that its primitives are in
  Aabb bounds;
  Aabb centroids;
  std::uint32_t size() const { return end - begin; }
};

/// A range still to be built, and the node that will be its root.
struct Open {
  std::uint32_t node;
  Range range;
};

class Build {
 public:
  Build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
        const BinnedSahBuilder::Config& config, Executor& executor)
      : boxes_(boxes), ids_(ids), config_(config), executor_(executor) {
    buffers_[0].resize(ids.size());
    if (ids.size() >= parallel_size) buffers_[1].resize(ids.size());
  }

  Bvh run() {
    Bvh bvh;
    if (ids_.empty()) return bvh;
    const Range root = fill();
    std::vector<Open> tasks = build_top(bvh.nodes, root);
    std::vector<Subtree> parts(tasks.size());
    bvh.prim_ids.resize(ids_.size());
    executor_.parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        parts[i].node = tasks[i].node;
        parts[i].depth = build_subtree(tasks[i].range, parts[i].nodes);
        std::uint32_t* id = &bvh.prim_ids[tasks[i].range.begin];
        for (const PrimRef& ref : refs(tasks[i].range)) *id++ = ref.id;
      }
    });
    splice(bvh, parts, executor_);
    return bvh;
  }

 private:
  std::span<PrimRef> refs(const Range& range) {
    return {buffers_[range.buffer].data() + range.begin, range.size()};
  }

  Range fill() {
    const std::size_t chunks = (ids_.size() + chunk - 1) / chunk;
    std::vector<Box4> bounds(chunks), centroids(chunks);
    executor_.parallel_for(ids_.size(), chunk, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const PrimRef ref = buffers_[0][i] = make_ref(ids_[i]);
        bounds[begin / chunk].extend(ref.lo4(), ref.hi4());
        centroids[begin / chunk].extend(ref.centroid4(), ref.centroid4());
      }
    });
    for (std::size_t i = 1; i < chunks; ++i) {
      bounds[0].extend(bounds[i]);
      centroids[0].extend(centroids[i]);
    }
    return {0, std::uint32_t(ids_.size()), 0, 0, bounds[0].aabb(), centroids[0].aabb()};
  }

  PrimRef make_ref(std::uint32_t id) const {
    const Aabb& b = boxes_[id];
    assert(!b.empty());
    return {{b.lo.x, b.lo.y, b.lo.z}, id, {b.hi.x, b.hi.y, b.hi.z}, 0};
  }

  /// Splits down to task size; returns what is left to do, in index order of its nodes.
  std::vector<Open> build_top(AlignedVector<Node>& nodes, const Range& root) {
    const std::size_t task_size = std::max<std::size_t>(config_.task_size, ids_.size() / 64);
    start_tree(nodes);
    std::vector<Open> tasks;
    std::vector<Open> open{{0, root}};
    while (!open.empty()) {
      const Open item = open.back();
      open.pop_back();
      Range left, right;
      if (item.range.size() <= task_size || !split(item.range, left, right)) {
        tasks.push_back(item);
        continue;
      }
      const std::uint32_t first = open_node(nodes, item);
      open.push_back({first + 1, right});
      open.push_back({first, left});
    }
    return tasks;
  }

  static std::uint32_t open_node(AlignedVector<Node>& nodes, const Open& item) {
    const std::uint32_t first = make_inner(nodes, item.node);
    nodes[item.node].set_bounds(item.range.bounds);
    return first;
  }

  /// Builds `root` into `nodes`, whose element 0 is its root and element 1 unused; returns the
  /// depth of its deepest leaf.
  std::uint32_t build_subtree(const Range& root, AlignedVector<Node>& nodes) {
    nodes.reserve(2 + root.size());
    start_tree(nodes);
    std::uint32_t depth = 0;
    std::vector<Open> open{{0, root}};
    while (!open.empty()) {
      const Open item = open.back();
      open.pop_back();
      Range left, right;
      if (!split(item.range, left, right)) {
        Node& leaf = nodes[item.node];
        leaf.first = item.range.begin;
        leaf.count = item.range.size();
        leaf.set_bounds(item.range.bounds);
        depth = std::max(depth, item.range.depth);
        continue;
      }
      const std::uint32_t first = open_node(nodes, item);
      open.push_back({first + 1, right});
      open.push_back({first, left});
    }
    return depth;
  }

  /// False: the range becomes a leaf.
  bool split(const Range& range, Range& left, Range& right) {
    const std::uint32_t n = range.size();
    // However good a split is, its node costs one test.
    if (n <= config_.max_leaf && n * config_.cost.leaf <= 1.0) return false;
    if (n == 1) return false;
    if (running_out_of_depth(range))
      return n > config_.max_leaf && median_split(range, left, right);
    if (n <= FewParted::most) return split_few(range, left, right);
    const BinMapping mapping(range.centroids, n);
    if (n >= parallel_size) return split_large(range, mapping, left, right);
    BinSet bins(mapping.count());
    bins.add(mapping, refs(range));
    const Split best = best_split(bins, mapping, n);
    if (n <= config_.max_leaf && !pays(range, best.cost)) return false;
    if (best.axis < 0) return n > config_.max_leaf && median_split(range, left, right);
    thread_local AlignedVector<PrimRef> spare;
    if (spare.size() < n) spare.resize(n);
    const auto goes_left = [&](const PrimRef& ref) {
      return mapping.is_below(ref, best.axis, best.bin);
    };
    const Partitioned parted = partition(refs(range), spare.data(), goes_left);
    divide(range, range.buffer, parted, left, right);
    bound(bins, mapping, best, left, right);
    return true;
  }

  /// On all threads, in pieces of `chunk`, from one buffer to the other.
  bool split_large(const Range& range, const BinMapping& mapping, Range& left, Range& right) {
    const std::span<const PrimRef> from = refs(range);
    std::vector<BinSet> parts((from.size() + chunk - 1) / chunk, BinSet(mapping.count()));
    executor_.parallel_for(from.size(), chunk, [&](std::size_t begin, std::size_t end) {
      parts[begin / chunk].add(mapping, from.subspan(begin, end - begin));
    });
    BinSet bins = parts[0];
    for (std::size_t i = 1; i < parts.size(); ++i) bins.merge(parts[i]);
    const Split best = best_split(bins, mapping, range.size());
    if (best.axis < 0) return median_split(range, left, right);
    std::vector<std::uint32_t> left_counts(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i)
      left_counts[i] = parts[i].count_below(best.axis, best.bin);
    const auto goes_left = [&](const PrimRef& ref) {
      return mapping.is_below(ref, best.axis, best.bin);
    };
    PrimRef* to = buffers_[1 - range.buffer].data() + range.begin;
    const Partitioned parted = partition_to(from, to, left_counts, chunk, goes_left, executor_);
    divide(range, 1 - range.buffer, parted, left, right);
    bound(bins, mapping, best, left, right);
    return true;
  }

  static void divide(const Range& range, std::uint32_t buffer, const Partitioned& parted,
                     Range& left, Range& right) {
    const std::uint32_t middle = range.begin + parted.count;
    left = {range.begin, middle, range.depth + 1, buffer, {}, parted.left.aabb()};
    right = {middle, range.end, range.depth + 1, buffer, {}, parted.right.aabb()};
  }

  static void bound(const BinSet& bins, const BinMapping& mapping, const Split& best, Range& left,
                    Range& right) {
    left.bounds = bins.bounds(best.axis, 0, best.bin).aabb();
    right.bounds = bins.bounds(best.axis, best.bin, mapping.count()).aabb();
  }

  /// Whether a split with that Σ area·count costs less than a leaf.
  bool pays(const Range& range, double cost) const {
    const double area = half_area(range.bounds);
    return area > 0.0 && 1.0 + config_.cost.leaf * cost / area < range.size() * config_.cost.leaf;
  }

  bool split_few(const Range& range, Range& left, Range& right) {
    const std::span<PrimRef> all = refs(range);
    const FewParted few(all);
    if (range.size() <= config_.max_leaf && !pays(range, few.cost)) return false;
    PrimRef sorted[FewParted::most];
    std::uint32_t l = 0, r = std::uint32_t(std::popcount(few.left));
    Partitioned parted;
    for (std::uint32_t i = 0; i < range.size(); ++i) {
      const bool is_left = (few.left >> i & 1) != 0;
      parted.add(all[i].centroid4(), is_left);
      sorted[is_left ? l++ : r++] = all[i];
    }
    std::copy(sorted, sorted + range.size(), all.begin());
    divide(range, range.buffer, parted, left, right);
    left.bounds = few.left_box.aabb();
    right.bounds = few.right_box.aabb();
    return true;
  }

  /// From here on only halving keeps the tree within its depth.
  bool running_out_of_depth(const Range& range) const {
    const auto halvings = std::uint32_t(std::bit_width(range.size()));
    return range.depth + halvings + 1 >= config_.max_depth;
  }

  bool median_split(const Range& range, Range& left, Range& right) {
    const Vec3d extents = range.centroids.extents();
    const int axis = extents.x >= extents.y && extents.x >= extents.z ? 0
                     : extents.y >= extents.z                         ? 1
                                                                      : 2;
    const std::span<PrimRef> all = refs(range);
    const std::uint32_t half = range.size() / 2;
    std::nth_element(all.begin(), all.begin() + half, all.end(),
                     [axis](const PrimRef& a, const PrimRef& b) {
                       const float ca = a.centroid(axis), cb = b.centroid(axis);
                       return ca != cb ? ca < cb : a.id < b.id;
                     });
    const std::uint32_t middle = range.begin + half;
    left = measured({range.begin, middle, range.depth + 1, range.buffer, {}, {}});
    right = measured({middle, range.end, range.depth + 1, range.buffer, {}, {}});
    return true;
  }

  Range measured(Range range) {
    Box4 bounds, centroids;
    for (const PrimRef& ref : refs(range)) {
      bounds.extend(ref.lo4(), ref.hi4());
      centroids.extend(ref.centroid4(), ref.centroid4());
    }
    range.bounds = bounds.aabb();
    range.centroids = centroids.aabb();
    return range;
  }

  std::span<const Aabb> boxes_;
  std::span<const std::uint32_t> ids_;
  const BinnedSahBuilder::Config& config_;
  Executor& executor_;
  /// Primitives in the order of the tree so far; the second takes what the threads part together.
  AlignedVector<PrimRef> buffers_[2];
};

}  // namespace

Bvh BinnedSahBuilder::build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
                            const Config& config, Executor& executor) {
  return Build(boxes, ids, config, executor).run();
}

}  // namespace regraft::bvh
