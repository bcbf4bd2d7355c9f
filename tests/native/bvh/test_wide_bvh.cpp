#include "regraft/bvh/wide_bvh.h"

#include <gtest/gtest.h>

#include <cstring>

#include "bvh/boxes.h"
#include "bvh/trees.h"
#include "bvh/wide_check.h"
#include "regraft/bvh/rotate.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::WideBvh;
using bvh::WideChild;
using bvh::WideNode;

template <int W>
bool same_nodes(const WideBvh& a, const WideBvh& b) {
  return a.node_count() == b.node_count() &&
         std::memcmp(a.nodes<W>(), b.nodes<W>(), a.node_count() * sizeof(WideNode<W>)) == 0;
}

class Width : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(WideBvh, Width, testing::Values(4, 8), testing::PrintToStringParamName());

TEST_P(Width, AnEmptyTreeHasNoNodes) {
  const WideBvh wide = WideBvh::derive({}, GetParam(), pool(1));
  EXPECT_TRUE(wide.empty());
  EXPECT_EQ(wide.width(), GetParam());
}

TEST_P(Width, EveryLeafIsThereOnceWithItsBox) {
  for (std::size_t count : {1, 2, 4, 5, 9, 33, 500, 20000}) {
    const Bvh bvh = random_boxes(count, count).build();
    EXPECT_EQ(flaw(WideBvh::derive(bvh, GetParam(), pool(2)), bvh), "") << count;
  }
}

TEST_P(Width, NodesAreWellFilled) {
  bvh::BinnedSahBuilder::Config config;
  config.max_leaf = 1;
  const Bvh bvh = random_boxes(4096, 1).build(2, config);
  const WideBvh wide = WideBvh::derive(bvh, GetParam(), pool(2));
  // 4,095 pairs of children were merged: full nodes would take 4095 / (width − 1).
  EXPECT_LT(double(wide.node_count()), 2.0 * 4095 / (GetParam() - 1));
}

TEST_P(Width, TheLayoutIsTheSameForAnyNumberOfThreads) {
  const Bvh bvh = random_boxes(20000, 2).build();
  const WideBvh one = WideBvh::derive(bvh, GetParam(), pool(1));
  for (const unsigned threads : {2u, 5u}) {
    const WideBvh other = WideBvh::derive(bvh, GetParam(), pool(threads));
    EXPECT_TRUE(GetParam() == 8 ? same_nodes<8>(one, other) : same_nodes<4>(one, other));
  }
}

TEST_P(Width, ARefitTakesOverEveryBox) {
  const Boxes first = random_boxes(5000, 3);
  Bvh bvh = first.build();
  WideBvh wide = WideBvh::derive(bvh, GetParam(), pool(2));
  Boxes moved = random_boxes(5000, 4, 50.0, 9.0);
  for (std::size_t i = 0; i < 100; ++i) moved.boxes[i] = Aabb{};
  for (const Boxes& boxes : {moved, first}) {
    bvh::refit(
        bvh, [&](std::uint32_t i) { return bvh::Box4(boxes.boxes[i]); }, pool(2));
    EXPECT_NE(flaw(wide, bvh), "");
    wide.refit(bvh, pool(5));
    EXPECT_EQ(flaw(wide, bvh), "");
  }
}

TEST_P(Width, TheDeepestTreeIsDerivedToo) {
  std::vector<Aabb> all;
  for (int i = 0; i < 20000; ++i) {
    const double x = std::exp2(-125.0 + 250.0 * i / 20000.0);
    all.push_back(cube({x, x, x}, x * 1e-3));
  }
  const Bvh bvh = Boxes(all).build();
  EXPECT_EQ(flaw(WideBvh::derive(bvh, GetParam(), pool(2)), bvh), "");
}

/// Where a partial update of a wide layout gets its changes from: a binary tree that is mended in
/// the three ways there are.
class Mender {
 public:
  Mender(std::size_t count, std::uint64_t seed) : boxes(random_boxes(count, seed)), random_(seed) {
    // Leaves of one: any place in the list of primitives will do for them.
    config_.max_leaf = 1;
    tree = boxes.build(2, config_);
  }

  /// Moves some primitives; boxes of `moved` pairs have changed, or of some below them.
  void move(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      boxes.boxes[random_.below(boxes.boxes.size())] = cube(random_.in_box(1.0), 0.05);
    const Bvh before = tree;
    refit_to(tree, boxes);
    moved.clear();
    list_moved(before, 0);
  }

  void rotate() {
    for (const bvh::Rotation& r : bvh::rotate(tree, {}, pool(2))) {
      changes.replaced.push_back(r.child);
      changes.replaced.push_back(r.grandchild);
    }
  }

  /// Builds a random subtree anew; its pairs of nodes are used again, in another order.
  void rebuild() {
    std::uint32_t n = 0;
    for (std::size_t down = 1 + random_.below(6); down > 0 && !tree.nodes[n].leaf(); --down)
      n = tree.nodes[n].first + std::uint32_t(random_.below(2));
    if (n == 0) return;
    std::vector<std::uint32_t> ids, slots, pairs = tree.free_pairs;
    for (const std::uint32_t below : nodes_below(tree, n)) {
      const bvh::Node& node = tree.nodes[below];
      if (!node.leaf()) pairs.push_back(node.first);
      for (std::uint32_t i = 0; i < node.count; ++i) slots.push_back(node.first + i);
    }
    std::sort(slots.begin(), slots.end());
    for (const std::uint32_t slot : slots) ids.push_back(tree.prim_ids[slot]);
    std::sort(ids.begin(), ids.end());
    graft(n, slots, bvh::BinnedSahBuilder::build(boxes.boxes, ids, config_, pool(1)), pairs);
    changes.rebuilt.push_back(n);
  }

  Boxes boxes;
  Bvh tree;
  bvh::Reshaping changes;
  std::vector<std::uint32_t> moved;

 private:
  /// Whether the box of `n` or one below has changed.
  bool list_moved(const Bvh& before, std::uint32_t n) {
    const bvh::Node& node = tree.nodes[n];
    bool is_moved = false;
    for (std::uint32_t side = 0; side < 2 && !node.leaf(); ++side)
      is_moved |= list_moved(before, node.first + side);
    if (is_moved) moved.push_back(node.first / 2);
    return is_moved || !(node == before.nodes[n]);
  }

  void graft(std::uint32_t root, const std::vector<std::uint32_t>& slots, const Bvh& part,
             std::vector<std::uint32_t>& pairs) {
    const auto place = [&](std::uint32_t n) { return n == 0 ? root : pairs[n / 2 - 1] + n % 2; };
    while (pairs.size() < part.nodes.size() / 2) {
      pairs.push_back(std::uint32_t(tree.nodes.size()));
      tree.nodes.resize(tree.nodes.size() + 2);
    }
    for (std::uint32_t n = 0; n < part.nodes.size(); ++n) {
      if (n == 1) continue;
      bvh::Node node = part.nodes[n];
      node.first = node.leaf() ? slots[node.first] : place(node.first);
      tree.nodes[place(n)] = node;
    }
    for (std::size_t i = 0; i < slots.size(); ++i) tree.prim_ids[slots[i]] = part.prim_ids[i];
    pairs.erase(pairs.begin(), pairs.begin() + std::ptrdiff_t(part.nodes.size() / 2 - 1));
    tree.free_pairs = pairs;
    for (const std::uint32_t pair : pairs) tree.nodes[pair] = tree.nodes[pair + 1] = {};
    tree.depth = height_of(tree, 0);
  }

  Random random_;
  bvh::BinnedSahBuilder::Config config_;
};

TEST_P(Width, AnUpdateReachesAllThatChangedAndNothingElse) {
  for (const std::size_t count : {3, 20, 300, 5000}) {
    Mender mender(count, count);
    WideBvh wide = WideBvh::derive(mender.tree, GetParam(), pool(2));
    WideBvh alone = wide;
    for (int frame = 0; frame < 30; ++frame) {
      mender.changes = {};
      mender.move(1 + count / 50);
      if (frame % 3 != 0) mender.rotate();
      if (frame % 3 != 1) mender.rebuild();
      ASSERT_EQ(mender.boxes.flaw(mender.tree), "");
      wide.update(mender.tree, mender.changes, pool(5));
      alone.update(mender.tree, mender.changes, pool(1));
      wide.refit(mender.tree, mender.moved, pool(5));
      alone.refit(mender.tree, mender.moved, pool(1));
      ASSERT_EQ(flaw(wide, mender.tree), "") << count << ", frame " << frame;
      EXPECT_TRUE(GetParam() == 8 ? same_nodes<8>(wide, alone) : same_nodes<4>(wide, alone));
    }
    // What is freed is used again, and nodes stay about as full as those of a fresh layout.
    const WideBvh fresh = WideBvh::derive(mender.tree, GetParam(), pool(2));
    const double used = double(wide.node_count() - wide.free_count());
    EXPECT_LE(used, 1.5 * double(fresh.node_count()) + 2) << count;
  }
}

TEST_P(Width, AnUpdateOfNothingChangesNothing) {
  const Mender mender(500, 1);
  WideBvh wide = WideBvh::derive(mender.tree, GetParam(), pool(2));
  const WideBvh before = wide;
  wide.update(mender.tree, {}, pool(2));
  EXPECT_TRUE(GetParam() == 8 ? same_nodes<8>(wide, before) : same_nodes<4>(wide, before));
}

TEST(WideChild, ALeafsRangeComesBackAndNoneIsNoLeafInUse) {
  for (const std::uint32_t begin : {0u, 1u, 123456u, WideChild::max_begin})
    for (std::uint32_t count = 1; count <= bvh::max_leaf_size; ++count) {
      const std::uint32_t child = WideChild::leaf(begin, count);
      EXPECT_TRUE(WideChild::is_leaf(child));
      EXPECT_EQ(WideChild::begin(child), begin);
      EXPECT_EQ(WideChild::count(child), count);
      EXPECT_TRUE(child != WideChild::none || (begin == WideChild::max_begin && count == 16));
    }
}

}  // namespace
}  // namespace regraft::test
