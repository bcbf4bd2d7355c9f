#include "regraft/bvh/validate.h"

#include <gtest/gtest.h>

#include <functional>

#include "bvh/boxes.h"

namespace regraft::test {
namespace {

using bvh::Bvh;
using bvh::Node;

class Validate : public testing::Test {
 protected:
  Validate() : tree(boxes.build()) {}

  /// What validate says of the tree after `damage`.
  std::string after(const std::function<void()>& damage) {
    damage();
    return boxes.flaw(tree);
  }
  Node& leaf() {
    for (std::size_t n = 2; n < tree.nodes.size(); ++n)
      if (tree.nodes[n].leaf()) return tree.nodes[n];
    return tree.nodes[0];
  }

  Boxes boxes = random_boxes(40, 1);
  Bvh tree;
};

TEST_F(Validate, AcceptsATreeThatWasBuilt) {
  EXPECT_EQ(boxes.flaw(tree), "");
}

TEST_F(Validate, SeesAPrimitiveThatIsThereTwice) {
  EXPECT_NE(after([&] { tree.prim_ids[0] = tree.prim_ids[1]; }), "");
}

TEST_F(Validate, SeesAPrimitiveThatIsNotThere) {
  boxes.ids.push_back(41);
  EXPECT_NE(boxes.flaw(tree), "");
  EXPECT_NE(after([&] { boxes.ids.pop_back(), boxes.ids.pop_back(); }), "");
}

TEST_F(Validate, SeesAnUnknownPrimitive) {
  EXPECT_NE(after([&] { tree.prim_ids[3] = 99; }), "");
}

TEST_F(Validate, SeesABoxThatIsLooseOrTight) {
  const Node whole = leaf();
  EXPECT_NE(after([&] { leaf().hi.x = std::nextafter(leaf().hi.x, inf); }), "");
  leaf() = whole;
  EXPECT_NE(after([&] { leaf().hi.x = std::nextafter(leaf().hi.x, -inf); }), "");
  leaf() = whole;
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_NE(after([&] { tree.nodes[0].lo.y -= 1.0f; }), "");
}

TEST_F(Validate, SeesAWrongDepth) {
  EXPECT_NE(after([&] { ++tree.depth; }), "");
}

TEST_F(Validate, SeesChildrenSharedOrInACircle) {
  EXPECT_NE(after([&] { tree.nodes[tree.nodes[0].first].first = tree.nodes[0].first; }), "");
}

TEST_F(Validate, SeesANodeNobodyReaches) {
  EXPECT_NE(after([&] { tree.nodes.resize(tree.nodes.size() + 2, bvh::Node{}); }), "");
}

TEST_F(Validate, SeesThatANodeNotInUseStillHasChildren) {
  tree.free_pairs.push_back(std::uint32_t(tree.nodes.size()));
  tree.nodes.resize(tree.nodes.size() + 2, bvh::Node{});
  EXPECT_EQ(boxes.flaw(tree), "");
  EXPECT_NE(after([&] { tree.nodes.back().first = 2; }), "");
}

TEST_F(Validate, SeesALeafThatReachesBeyondTheEnd) {
  EXPECT_NE(after([&] { leaf().first = 39; }), "");
}

TEST_F(Validate, SeesALeafThatIsTooLarge) {
  const Boxes many(std::vector<Aabb>(17, Aabb{Vec3(0), Vec3(1)}));
  Bvh one;
  one.nodes.resize(2, bvh::Node{});
  one.nodes[0].set_bounds(many.boxes[0]);
  one.nodes[0].count = 17;
  one.prim_ids = many.ids;
  EXPECT_NE(many.flaw(one), "");
}

TEST_F(Validate, SeesAnEmptyTreeWherePrimitivesAreWanted) {
  EXPECT_NE(boxes.flaw(Bvh{}), "");
  EXPECT_EQ(Boxes().flaw(Bvh{}), "");
}

}  // namespace
}  // namespace regraft::test
