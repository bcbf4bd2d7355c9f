#include "regraft/bvh/wide_bvh.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "bvh/boxes.h"
#include "regraft/bvh/refit.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::WideBvh;
using bvh::WideChild;
using bvh::WideNode;

template <int W>
Aabb slot_box(const WideNode<W>& node, int slot) {
  const auto plane = [&](int k) { return node.bounds[k][slot]; };
  return {Vec3(plane(0), plane(1), plane(2)), Vec3(plane(3), plane(4), plane(5))};
}

/// Walks a wide tree and collects what is wrong with it.
template <int W>
class Check {
 public:
  Check(const WideBvh& wide, const Bvh& bvh) : wide_(wide), bvh_(bvh) {}

  std::string flaw() {
    visit(0);
    if (flaw_.empty() && nodes_.size() != wide_.node_count()) flaw_ = "nodes are not reached";
    std::size_t leaves = 0;
    for (std::size_t n = 0; n < bvh_.nodes.size(); ++n) leaves += n != 1 && bvh_.nodes[n].leaf();
    if (flaw_.empty() && leaves_.size() != leaves) flaw_ = "leaves are missing";
    return flaw_;
  }

 private:
  void visit(std::uint32_t index) {
    if (index >= wide_.node_count() || !nodes_.insert(index).second) {
      flaw_ = "a node is reached twice or out of range";
      return;
    }
    const WideNode<W>& node = wide_.nodes<W>()[index];
    bool ended = false;
    for (int i = 0; i < W && flaw_.empty(); ++i) {
      ended |= node.child[i] == WideChild::none;
      if (ended)
        check_unused(node, i);
      else
        check_used(node, i);
    }
  }

  void check_unused(const WideNode<W>& node, int slot) {
    if (node.child[slot] != WideChild::none) flaw_ = "an unused slot lies between used ones";
    if (!slot_box(node, slot).empty()) flaw_ = "an unused slot has a box";
  }

  void check_used(const WideNode<W>& node, int slot) {
    const bvh::Node& source = bvh_.nodes[node.source[slot]];
    if (!(slot_box(node, slot) == source.bounds())) flaw_ = "a box is not that of the binary tree";
    const std::uint32_t child = node.child[slot];
    if (!WideChild::is_leaf(child)) {
      if (source.leaf()) flaw_ = "a leaf became an inner node";
      visit(child);
      return;
    }
    if (WideChild::begin(child) != source.first || WideChild::count(child) != source.count)
      flaw_ = "a leaf's range is not that of the binary tree";
    if (!leaves_.insert(node.source[slot]).second) flaw_ = "a leaf is there twice";
  }

  const WideBvh& wide_;
  const Bvh& bvh_;
  std::set<std::uint32_t> nodes_, leaves_;
  std::string flaw_;
};

std::string flaw(const WideBvh& wide, const Bvh& bvh) {
  return wide.width() == 8 ? Check<8>(wide, bvh).flaw() : Check<4>(wide, bvh).flaw();
}

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
