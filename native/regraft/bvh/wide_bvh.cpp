#include "regraft/bvh/wide_bvh.h"

#include <cassert>
#include <limits>

namespace regraft::bvh {

namespace {

/// A wide node still to be filled, and the binary node at its root.
struct Open {
  std::uint32_t wide;
  std::uint32_t binary;
};

template <int W>
void set_box(WideNode<W>& node, int slot, const Aabb& box) {
  for (int k = 0; k < 3; ++k) {
    node.bounds[k][slot] = box.lo[k];
    node.bounds[3 + k][slot] = box.hi[k];
  }
}

/// Up to W descendants of `root` that together hold all it holds, largest boxes opened first.
template <int W>
int collect_children(const Bvh& bvh, std::uint32_t root, std::uint32_t (&children)[W]) {
  int count = 1;
  children[0] = root;
  while (count < W) {
    int largest = -1;
    double largest_area = -1.0;
    for (int i = 0; i < count; ++i) {
      const Node& node = bvh.nodes[children[i]];
      const double area = node.leaf() ? -1.0 : half_area(node.bounds());
      if (area > largest_area) {
        largest_area = area;
        largest = i;
      }
    }
    if (largest < 0) break;
    const std::uint32_t first = bvh.nodes[children[largest]].first;
    children[largest] = first;
    children[count++] = first + 1;
  }
  return count;
}

/// Fills nodes from the open ones on until none is left, or `limit` are open.
template <int W>
void fill(const Bvh& bvh, AlignedVector<WideNode<W>>& nodes, std::vector<Open>& open,
          std::size_t limit) {
  for (std::size_t next = 0; next < open.size();) {
    if (open.size() - next >= limit) {
      open.erase(open.begin(), open.begin() + std::ptrdiff_t(next));
      return;
    }
    const Open item = open[next++];
    std::uint32_t children[W];
    const int count = collect_children<W>(bvh, item.binary, children);
    WideNode<W> filled;
    for (int i = 0; i < W; ++i) {
      const bool used = i < count;
      set_box(filled, i, used ? bvh.nodes[children[i]].bounds() : Aabb{});
      filled.source[i] = used ? children[i] : 0;
      filled.child[i] = WideChild::none;
      if (!used) continue;
      const Node& node = bvh.nodes[children[i]];
      if (node.leaf()) {
        filled.child[i] = WideChild::leaf(node.first, node.count);
        continue;
      }
      filled.child[i] = std::uint32_t(nodes.size());
      nodes.emplace_back();
      open.push_back({filled.child[i], children[i]});
    }
    nodes[item.wide] = filled;
  }
  open.clear();
}

/// The top serially, the subtrees below it as tasks of their own, joined in order.
template <int W>
void collapse(const Bvh& bvh, AlignedVector<WideNode<W>>& nodes, Executor& executor) {
  constexpr std::size_t tasks = 64;
  nodes.emplace_back();
  std::vector<Open> open{{0, 0}};
  fill<W>(bvh, nodes, open, tasks);
  std::vector<AlignedVector<WideNode<W>>> parts(open.size());
  executor.parallel_for(open.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      parts[i].emplace_back();
      std::vector<Open> rest{{0, open[i].binary}};
      fill<W>(bvh, parts[i], rest, std::numeric_limits<std::size_t>::max());
    }
  });
  std::vector<std::size_t> offsets(parts.size());
  std::size_t total = nodes.size();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    offsets[i] = total - 1;
    total += parts[i].size() - 1;
  }
  nodes.resize(total);
  executor.parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t n = 0; n < parts[i].size(); ++n) {
        WideNode<W> node = parts[i][n];
        for (std::uint32_t& child : node.child)
          if (!WideChild::is_leaf(child)) child += std::uint32_t(offsets[i]);
        nodes[n == 0 ? open[i].wide : offsets[i] + n] = node;
      }
  });
}

template <int W>
void take_boxes(const Bvh& bvh, AlignedVector<WideNode<W>>& nodes, Executor& executor) {
  executor.parallel_for(nodes.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n)
      for (int i = 0; i < W && nodes[n].child[i] != WideChild::none; ++i)
        set_box(nodes[n], i, bvh.nodes[nodes[n].source[i]].bounds());
  });
}

}  // namespace

WideBvh WideBvh::derive(const Bvh& bvh, int width, Executor& executor) {
  assert(width == 4 || width == 8);
  WideBvh wide;
  wide.width_ = width;
  if (bvh.empty()) return wide;
  if (width == 8)
    collapse<8>(bvh, wide.nodes8_, executor);
  else
    collapse<4>(bvh, wide.nodes4_, executor);
  return wide;
}

void WideBvh::refit(const Bvh& bvh, Executor& executor) {
  if (width_ == 8)
    take_boxes<8>(bvh, nodes8_, executor);
  else
    take_boxes<4>(bvh, nodes4_, executor);
}

}  // namespace regraft::bvh
