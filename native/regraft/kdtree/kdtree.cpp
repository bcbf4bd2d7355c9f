#include "regraft/kdtree/kdtree.h"

#include <memory>
#include <thread>
#include <vector>

#include "regraft/kdtree/origin_space.h"

namespace regraft::kdtree {

namespace {

/// A cell is forgotten as a whole when this part of the lines through it meets one region.
constexpr double covers = 0.5;

std::int64_t size_of(const Pending& pending) {
  return std::int64_t(sizeof(Pending) + pending.list.capacity() * sizeof(HierarchyEntry));
}

/// Calls `visit` for every node below and including `node` that exists.
template <typename F>
void walk(Node& node, const F& visit) {
  std::vector<Node*> stack{&node};
  while (!stack.empty()) {
    Node& next = *stack.back();
    stack.pop_back();
    const std::uint32_t state = next.state.load(std::memory_order_acquire);
    if (Node::is_inner(state)) {
      stack.push_back(next.children + 1);
      stack.push_back(next.children);
    }
    visit(next, state);
  }
}

}  // namespace

KdTree::KdTree(const HierarchyView& view, const Config& config, Executor& executor)
    : view_(view), builder_(view, config) {
  root_ = allocate_pair();
  root_->pending = keep(builder_.root());
  if (!config.lazy) complete(executor);
}

KdTree::~KdTree() {
  walk(*root_, [](Node& node, std::uint32_t state) {
    if (state == Node::unbuilt) delete node.pending;
  });
}

Node* KdTree::allocate_pair() const {
  Node* pair = static_cast<Node*>(pool_.allocate(2 * sizeof(Node)));
  std::uninitialized_default_construct_n(pair, 2);
  made_.fetch_add(2, std::memory_order_relaxed);
  return pair;
}

void KdTree::expand(Node& node) const {
  std::uint32_t state = Node::unbuilt;
  if (!node.state.compare_exchange_strong(state, Node::building, std::memory_order_acquire)) {
    while (node.state.load(std::memory_order_acquire) == Node::building) std::this_thread::yield();
    return;
  }
  const Pending* pending = node.pending;
  try {
    publish(node, builder_.build(*pending));
  } catch (...) {
    node.state.store(Node::unbuilt, std::memory_order_release);
    throw;
  }
  forget(pending);
}

Pending* KdTree::keep(Pending&& pending) const {
  auto* kept = new Pending(std::move(pending));
  pending_bytes_.fetch_add(size_of(*kept), std::memory_order_relaxed);
  pending_weight_.fetch_add(std::int64_t(kept->weight), std::memory_order_relaxed);
  return kept;
}

void KdTree::forget(const Pending* pending) const {
  pending_bytes_.fetch_sub(size_of(*pending), std::memory_order_relaxed);
  pending_weight_.fetch_sub(std::int64_t(pending->weight), std::memory_order_relaxed);
  delete pending;
}

void KdTree::publish(Node& node, Built&& built) const {
  if (built.axis < 0) return publish_leaf(node, built.prims);
  Node* children = allocate_pair();
  for (int s = 0; s < 2; ++s) {
    if (builder_.surely_leaf(built.children[s]))
      publish_leaf(children[s], builder_.build(built.children[s]).prims);
    else
      children[s].pending = keep(std::move(built.children[s]));
  }
  node.split = built.position;
  node.children = children;
  node.state.store(std::uint32_t(built.axis), std::memory_order_release);
}

void KdTree::publish_leaf(Node& node, std::span<const PrimRef> prims) const {
  auto* refs = static_cast<PrimRef*>(pool_.allocate(prims.size_bytes()));
  std::uninitialized_copy(prims.begin(), prims.end(), refs);
  node.prims = refs;
  node.state.store(Node::leaf | std::uint32_t(prims.size()) << Node::kind_bits,
                   std::memory_order_release);
}

void KdTree::complete(Executor& executor) const {
  // Breadth first until there is work for every thread; then each subtree by one.
  std::vector<Node*> todo{root_}, next;
  const std::size_t enough = executor.threads() == 1 ? 1 : 32 * std::size_t(executor.threads());
  while (!todo.empty() && todo.size() < enough) {
    next.clear();
    for (Node* node : todo) {
      expand(*node);
      if (!Node::is_inner(node->state.load(std::memory_order_acquire))) continue;
      next.push_back(node->children);
      next.push_back(node->children + 1);
    }
    todo.swap(next);
  }
  executor.parallel_for(todo.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) build_below(*todo[i]);
  });
}

void KdTree::build_below(Node& node) const {
  std::vector<Node*> stack{&node};
  while (!stack.empty()) {
    Node& next = *stack.back();
    stack.pop_back();
    expand(next);
    if (!Node::is_inner(next.state.load(std::memory_order_acquire))) continue;
    stack.push_back(next.children + 1);
    stack.push_back(next.children);
  }
}

void KdTree::invalidate(std::span<const Aabb> regions) {
  invalidate({root_, bounds(), 0}, regions);
}

void KdTree::invalidate(const Cell& cell, std::span<const Aabb> regions) {
  std::vector<Aabb> met;
  bool covered = false;
  for (const Aabb& region : regions) {
    const Aabb part = clipped(region, cell.voxel);
    if (part.empty()) continue;
    met.push_back(part);
    covered = covered || hit_probability(part, cell.voxel) > covers;
  }
  if (met.empty()) return;
  const std::uint32_t state = cell.node->state.load(std::memory_order_acquire);
  if (covered || !Node::is_inner(state)) return renew(cell);
  for (int s = 0; s < 2; ++s) {
    Cell child{cell.node->children + s, cell.voxel, cell.depth + 1};
    (s == 0 ? child.voxel.hi : child.voxel.lo)[int(state)] = cell.node->split;
    invalidate(child, met);
  }
}

/// Makes the node unbuilt again.
void KdTree::renew(const Cell& cell) {
  double weight = 0.0;
  walk(*cell.node, [&](Node& node, std::uint32_t state) {
    if (Node::is_built(state)) ++forgotten_;
    if (Node::kind(state) == Node::leaf) weight += Node::prim_count(state);
    if (state != Node::unbuilt) return;
    weight += node.pending->weight;
    forget(node.pending);
  });
  Pending pending = builder_.seed(cell.voxel, cell.depth, Pending::by_weight);
  // Of entries as coarse as these nearly all is elsewhere.
  pending.weight = weight;
  cell.node->pending = keep(std::move(pending));
  cell.node->state.store(Node::unbuilt, std::memory_order_release);
}

std::size_t KdTree::bytes() const {
  return sizeof(KdTree) + pool_.bytes() +
         std::size_t(pending_bytes_.load(std::memory_order_relaxed));
}

}  // namespace regraft::kdtree
