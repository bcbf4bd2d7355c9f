#include "regraft/bvh/key_frame_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "regraft/bvh/binning.h"
#include "regraft/bvh/subtrees.h"

namespace regraft::bvh {

namespace {

constexpr std::size_t max_frames = KeyFrameBuilder::max_frames;

/// One box in every key frame.
using Boxes = std::array<Box4, max_frames>;

struct Range {
  std::uint32_t begin;
  std::uint32_t end;
  std::uint32_t depth;
  std::uint32_t size() const { return end - begin; }
};

struct Task {
  std::uint32_t node;
  Range range;
};

/// The best plane across the axes of one key frame.
struct Choice {
  int axis = -1;
  int bin = 0;
  double cost = std::numeric_limits<double>::infinity();
};

class Build {
 public:
  Build(std::span<const std::span<const Aabb>> frames, std::span<const std::uint32_t> ids,
        const KeyFrameBuilder::Config& config, Executor& executor)
      : frames_(frames), config_(config), executor_(executor), order_(ids.begin(), ids.end()) {
    assert(!frames.empty() && frames.size() <= max_frames);
    weights_.fill(1.0);
    const Boxes all = bounds({0, std::uint32_t(ids.size()), 0});
    for (std::size_t j = 0; j < frames_.size(); ++j) {
      const double area = half_area(all[j].aabb());
      // A frame in which all is flat or gone tells nothing, but then no frame may outweigh it.
      weights_[j] = area > 0.0 ? 1.0 / area : 0.0;
    }
  }

  Bvh run() {
    Bvh bvh;
    if (order_.empty()) return bvh;
    std::vector<Task> tasks;
    build_top(bvh.nodes, tasks);
    const std::size_t top_size = bvh.nodes.size();
    std::vector<Subtree> parts(tasks.size());
    executor_.parallel_for(tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        parts[i].node = tasks[i].node;
        start_tree(parts[i].nodes);
        build_node(tasks[i].range, 0, parts[i]);
      }
    });
    bvh.prim_ids = order_;
    splice(bvh, parts, executor_);
    close_top(bvh, top_size);
    return bvh;
  }

 private:
  void build_top(AlignedVector<Node>& nodes, std::vector<Task>& tasks) {
    const std::size_t task_size = std::max<std::size_t>(config_.task_size, order_.size() / 64);
    start_tree(nodes);
    std::vector<Task> open{{0, {0, std::uint32_t(order_.size()), 0}}};
    while (!open.empty()) {
      const Task item = open.back();
      open.pop_back();
      const std::uint32_t middle = item.range.size() <= task_size ? 0 : split(item.range);
      if (middle == 0) {
        tasks.push_back(item);
        continue;
      }
      const std::uint32_t first = make_inner(nodes, item.node);
      open.push_back({first + 1, {middle, item.range.end, item.range.depth + 1}});
      open.push_back({first, {item.range.begin, middle, item.range.depth + 1}});
    }
  }

  Box4 build_node(const Range& range, std::uint32_t node, Subtree& part) {
    Box4 box;
    const std::uint32_t middle = split(range);
    if (middle == 0) {
      for (std::uint32_t i = range.begin; i < range.end; ++i)
        box.extend(Box4(frames_[0][order_[i]]));
      part.depth = std::max(part.depth, range.depth);
      part.nodes[node].first = range.begin;
      part.nodes[node].count = range.size();
    } else {
      const std::uint32_t first = make_inner(part.nodes, node);
      box = build_node({range.begin, middle, range.depth + 1}, first, part);
      box.extend(build_node({middle, range.end, range.depth + 1}, first + 1, part));
    }
    part.nodes[node].set_bounds(box.aabb());
    return box;
  }

  /// Where the range is parted, its order changed for that; 0: it becomes a leaf.
  std::uint32_t split(const Range& range) {
    const std::uint32_t n = range.size();
    if (n <= config_.max_leaf && n * config_.cost.leaf <= 1.0) return 0;
    if (n == 1) return 0;
    const std::uint32_t half = range.begin + n / 2;
    const auto halvings = std::uint32_t(std::bit_width(n));
    if (range.depth + halvings + 1 >= max_depth) return n <= config_.max_leaf ? 0 : half;
    std::array<Choice, max_frames> choices;
    executor_.parallel_for(frames_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t j = begin; j < end; ++j) choices[j] = choose(range, j);
    });
    std::size_t best = 0;
    for (std::size_t j = 1; j < frames_.size(); ++j)
      if (choices[j].cost < choices[best].cost) best = j;
    const double area = weigh(bounds(range));
    const double leaf_cost = n * config_.cost.leaf;
    const bool pays = area > 0.0 && 1.0 + config_.cost.leaf * choices[best].cost / area < leaf_cost;
    if (n <= config_.max_leaf && !pays) return 0;
    return choices[best].axis < 0 ? half : partition(range, best, choices[best]);
  }

  std::uint32_t partition(const Range& range, std::size_t frame, const Choice& choice) {
    const BinMapping mapping(centroids(range, frame), range.size());
    const auto middle = std::stable_partition(
        order_.begin() + range.begin, order_.begin() + range.end, [&](std::uint32_t id) {
          return mapping.is_below(ref(frame, id), choice.axis, choice.bin);
        });
    return std::uint32_t(middle - order_.begin());
  }

  Choice choose(const Range& range, std::size_t frame) const {
    const BinMapping mapping(centroids(range, frame), range.size());
    Boxes box[3][max_bins];
    std::uint32_t count[3][max_bins] = {};
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const std::array<int, 3> bin = mapping.bins(ref(frame, order_[i]));
      for (int k = 0; k < 3; ++k) ++count[k][bin[k]];
      for (std::size_t j = 0; j < frames_.size(); ++j) {
        const Box4 prim(frames_[j][order_[i]]);
        for (int k = 0; k < 3; ++k) box[k][bin[k]][j].extend(prim);
      }
    }
    Choice best;
    for (int k = 0; k < 3; ++k)
      if (mapping.usable(k)) sweep(k, {box[k], std::size_t(mapping.count())}, count[k], best);
    return best;
  }

  void sweep(int axis, std::span<const Boxes> bins, const std::uint32_t* count,
             Choice& best) const {
    double right_cost[max_bins];
    Boxes sum;
    std::uint32_t size = 0;
    for (std::size_t i = bins.size(); i-- > 0;) {
      extend(sum, bins[i]);
      size += count[i];
      right_cost[i] = size * weigh(sum);
    }
    sum = {};
    std::uint32_t left = 0;
    for (std::size_t i = 1; i < bins.size(); ++i) {
      extend(sum, bins[i - 1]);
      left += count[i - 1];
      if (left == 0 || left == size) continue;
      const double cost = left * weigh(sum) + right_cost[i];
      if (cost < best.cost) best = {axis, int(i), cost};
    }
  }

  void extend(Boxes& boxes, const Boxes& by) const {
    for (std::size_t j = 0; j < frames_.size(); ++j) boxes[j].extend(by[j]);
  }
  /// Σ_j A_j/A_j(root).
  double weigh(const Boxes& boxes) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < frames_.size(); ++j)
      sum += weights_[j] * half_area(boxes[j].aabb());
    return sum;
  }
  Boxes bounds(const Range& range) const {
    Boxes boxes;
    for (std::uint32_t i = range.begin; i < range.end; ++i)
      for (std::size_t j = 0; j < frames_.size(); ++j) boxes[j].extend(Box4(frames_[j][order_[i]]));
    return boxes;
  }
  PrimRef ref(std::size_t frame, std::uint32_t id) const {
    const Aabb& b = frames_[frame][id];
    return {{b.lo.x, b.lo.y, b.lo.z}, id, {b.hi.x, b.hi.y, b.hi.z}, 0};
  }
  /// Those of empty boxes are NaN, and ignored.
  Aabb centroids(const Range& range, std::size_t frame) const {
    Box4 box;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Float4 c = ref(frame, order_[i]).centroid4();
      box.extend(c, c);
    }
    return box.aabb();
  }

  std::span<const std::span<const Aabb>> frames_;
  const KeyFrameBuilder::Config& config_;
  Executor& executor_;
  std::array<double, max_frames> weights_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

Bvh KeyFrameBuilder::build(std::span<const std::span<const Aabb>> frames,
                           std::span<const std::uint32_t> ids, const Config& config,
                           Executor& executor) {
  return Build(frames, ids, config, executor).run();
}

}  // namespace regraft::bvh
