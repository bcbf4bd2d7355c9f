#include "regraft/bvh/binned_sah_builder.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "regraft/bvh/binning.h"
#include "regraft/bvh/part_few.h"
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
  Aabb bounds;
  Aabb centroids;
  std::uint32_t size() const { return end - begin; }
};

/// A range still to be built, and the node that will be its root.
struct Open {
  std::uint32_t node;
  Range range;
};

struct Partitioned {
  std::uint32_t middle = 0;
  Box4 left, right;  ///< of centroids
};

class Build {
 public:
  Build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
        const BinnedSahBuilder::Config& config, Executor& executor)
      : boxes_(boxes), ids_(ids), config_(config), executor_(executor), refs_(ids.size()) {}

  Bvh run() {
    Bvh bvh;
    if (ids_.empty()) return bvh;
    const Range root = fill();
    std::vector<Open> tasks = build_top(bvh.nodes, root);
    std::vector<Subtree> parts(tasks.size());
    executor_.parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        parts[i].node = tasks[i].node;
        parts[i].depth = build_subtree(tasks[i].range, parts[i].nodes);
      }
    });
    splice(bvh, parts, executor_);
    bvh.prim_ids.resize(refs_.size());
    for (std::size_t i = 0; i < refs_.size(); ++i) bvh.prim_ids[i] = refs_[i].id;
    return bvh;
  }

 private:
  Range fill() {
    const std::size_t chunks = (ids_.size() + chunk - 1) / chunk;
    std::vector<Box4> bounds(chunks), centroids(chunks);
    executor_.parallel_for(ids_.size(), chunk, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        refs_[i] = make_ref(ids_[i]);
        bounds[begin / chunk].extend(refs_[i].lo4(), refs_[i].hi4());
        centroids[begin / chunk].extend(refs_[i].centroid4(), refs_[i].centroid4());
      }
    });
    for (std::size_t i = 1; i < chunks; ++i) {
      bounds[0].extend(bounds[i]);
      centroids[0].extend(centroids[i]);
    }
    return {0, std::uint32_t(ids_.size()), 0, bounds[0].aabb(), centroids[0].aabb()};
  }

  PrimRef make_ref(std::uint32_t id) const {
    const Aabb& b = boxes_[id];
    assert(!b.empty());
    return {{b.lo.x, b.lo.y, b.lo.z}, id, {b.hi.x, b.hi.y, b.hi.z}, 0};
  }

  /// Splits down to task size; returns what is left to do, in index order of its nodes.
  std::vector<Open> build_top(AlignedVector<Node>& nodes, const Range& root) {
    const std::size_t task_size = std::max<std::size_t>(config_.task_size, ids_.size() / 64);
    nodes.resize(2);
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
    nodes.resize(2);
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
    BinSet bins(mapping.count());
    bin(range, mapping, bins);
    const Split best = best_split(bins, mapping, n);
    if (n <= config_.max_leaf && !pays(range, best.cost)) return false;
    if (best.axis < 0) return n > config_.max_leaf && median_split(range, left, right);
    const Partitioned parts = partition(range, mapping, best);
    left = {range.begin, parts.middle, range.depth + 1, bins.bounds(best.axis, 0, best.bin).aabb(),
            parts.left.aabb()};
    right = {parts.middle, range.end, range.depth + 1,
             bins.bounds(best.axis, best.bin, mapping.count()).aabb(), parts.right.aabb()};
    return true;
  }

  /// Whether a split with that Σ area·count costs less than a leaf.
  bool pays(const Range& range, double cost) const {
    const double area = half_area(range.bounds);
    return area > 0.0 && 1.0 + config_.cost.leaf * cost / area < range.size() * config_.cost.leaf;
  }

  bool split_few(const Range& range, Range& left, Range& right) {
    PrimRef* refs = refs_.data() + range.begin;
    const FewParted parted({refs, range.size()});
    if (range.size() <= config_.max_leaf && !pays(range, parted.cost)) return false;
    PrimRef sorted[FewParted::most];
    std::uint32_t l = 0, r = std::uint32_t(std::popcount(parted.left));
    const std::uint32_t middle = range.begin + r;
    for (std::uint32_t i = 0; i < range.size(); ++i)
      sorted[(parted.left >> i & 1) != 0 ? l++ : r++] = refs[i];
    std::copy(sorted, sorted + range.size(), refs);
    left = {range.begin, middle, range.depth + 1, parted.left_box.aabb(),
            centroids(range.begin, middle).aabb()};
    right = {middle, range.end, range.depth + 1, parted.right_box.aabb(),
             centroids(middle, range.end).aabb()};
    return true;
  }

  /// From here on only halving keeps the tree within its depth.
  bool running_out_of_depth(const Range& range) const {
    const auto halvings = std::uint32_t(std::bit_width(range.size()));
    return range.depth + halvings + 1 >= config_.max_depth;
  }

  void bin(const Range& range, const BinMapping& mapping, BinSet& bins) {
    const std::span<const PrimRef> refs(refs_.data() + range.begin, range.size());
    if (range.size() < parallel_size) {
      bins.add(mapping, refs);
      return;
    }
    std::vector<BinSet> parts((refs.size() + chunk - 1) / chunk, BinSet(mapping.count()));
    executor_.parallel_for(refs.size(), chunk, [&](std::size_t begin, std::size_t end) {
      parts[begin / chunk].add(mapping, refs.subspan(begin, end - begin));
    });
    for (const BinSet& part : parts) bins.merge(part);
  }

  Partitioned partition(const Range& range, const BinMapping& mapping, const Split& best) {
    const auto goes_left = [&](const PrimRef& ref) {
      return mapping.is_below(ref, best.axis, best.bin);
    };
    thread_local AlignedVector<PrimRef> spare;
    return range.size() < parallel_size ? partition_serial(range, goes_left, spare)
                                        : partition_parallel(range, goes_left);
  }

  /// Every primitive is written to where either side goes on, and one of the two moves on: no
  /// processor could guess a branch here. The order within the sides stays.
  template <typename F>
  Partitioned partition_serial(const Range& range, const F& goes_left,
                               AlignedVector<PrimRef>& spare) {
    if (spare.size() < range.size()) spare.resize(range.size());
    PrimRef* left = refs_.data() + range.begin;
    PrimRef* right = spare.data();
    for (const PrimRef *ref = left, *end = refs_.data() + range.end; ref < end; ++ref) {
      const PrimRef copy = *ref;
      const bool is_left = goes_left(copy);
      *left = copy;
      *right = copy;
      left += is_left;
      right += !is_left;
    }
    Partitioned result;
    result.middle = std::uint32_t(left - refs_.data());
    std::copy(spare.data(), right, left);
    result.left = centroids(range.begin, result.middle);
    result.right = centroids(result.middle, range.end);
    return result;
  }

  Box4 centroids(std::uint32_t begin, std::uint32_t end) const {
    Box4 box;
    for (std::uint32_t i = begin; i < end; ++i) {
      const Float4 c = refs_[i].centroid4();
      box.extend(c, c);
    }
    return box;
  }

  /// Counts, then scatters each chunk to its place: the order does not depend on the threads.
  template <typename F>
  Partitioned partition_parallel(const Range& range, const F& goes_left) {
    const std::span<PrimRef> refs(refs_.data() + range.begin, range.size());
    scratch_.resize(refs_.size());
    std::vector<Partitioned> parts((refs.size() + chunk - 1) / chunk);
    executor_.parallel_for(refs.size(), chunk, [&](std::size_t begin, std::size_t end) {
      Partitioned& part = parts[begin / chunk];
      for (std::size_t i = begin; i < end; ++i) {
        const Float4 c = refs[i].centroid4();
        const bool is_left = goes_left(refs[i]);
        part.middle += is_left;
        (is_left ? part.left : part.right).extend(c, c);
      }
    });
    Partitioned result;
    for (const Partitioned& part : parts) {
      result.middle += part.middle;
      result.left.extend(part.left);
      result.right.extend(part.right);
    }
    std::vector<std::size_t> left_at(parts.size()), right_at(parts.size());
    for (std::size_t i = 0, l = 0, r = result.middle; i < parts.size(); ++i) {
      left_at[i] = l;
      right_at[i] = r;
      l += parts[i].middle;
      r += std::min(chunk, refs.size() - i * chunk) - parts[i].middle;
    }
    executor_.parallel_for(refs.size(), chunk, [&](std::size_t begin, std::size_t end) {
      std::size_t l = left_at[begin / chunk], r = right_at[begin / chunk];
      for (std::size_t i = begin; i < end; ++i) scratch_[goes_left(refs[i]) ? l++ : r++] = refs[i];
    });
    executor_.parallel_for(refs.size(), chunk, [&](std::size_t begin, std::size_t end) {
      std::copy(scratch_.begin() + std::ptrdiff_t(begin), scratch_.begin() + std::ptrdiff_t(end),
                refs.begin() + std::ptrdiff_t(begin));
    });
    result.middle += range.begin;
    return result;
  }

  bool median_split(const Range& range, Range& left, Range& right) {
    const Vec3d extents = range.centroids.extents();
    const int axis = extents.x >= extents.y && extents.x >= extents.z ? 0
                     : extents.y >= extents.z                         ? 1
                                                                      : 2;
    const std::uint32_t middle = range.begin + range.size() / 2;
    std::nth_element(refs_.begin() + range.begin, refs_.begin() + middle, refs_.begin() + range.end,
                     [axis](const PrimRef& a, const PrimRef& b) {
                       const float ca = a.centroid(axis), cb = b.centroid(axis);
                       return ca != cb ? ca < cb : a.id < b.id;
                     });
    left = measured(range.begin, middle, range.depth + 1);
    right = measured(middle, range.end, range.depth + 1);
    return true;
  }

  Range measured(std::uint32_t begin, std::uint32_t end, std::uint32_t depth) const {
    Box4 bounds, centroids;
    for (std::uint32_t i = begin; i < end; ++i) {
      bounds.extend(refs_[i].lo4(), refs_[i].hi4());
      centroids.extend(refs_[i].centroid4(), refs_[i].centroid4());
    }
    return {begin, end, depth, bounds.aabb(), centroids.aabb()};
  }

  std::span<const Aabb> boxes_;
  std::span<const std::uint32_t> ids_;
  const BinnedSahBuilder::Config& config_;
  Executor& executor_;
  AlignedVector<PrimRef> refs_;
  AlignedVector<PrimRef> scratch_;
};

}  // namespace

Bvh BinnedSahBuilder::build(std::span<const Aabb> boxes, std::span<const std::uint32_t> ids,
                            const Config& config, Executor& executor) {
  return Build(boxes, ids, config, executor).run();
}

}  // namespace regraft::bvh
