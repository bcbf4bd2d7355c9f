#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "accel/tended.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::NodeBatch;
using accel::Policy;

Mat4d at(double x) {
  return glm::translate(Mat4d(1.0), Vec3d(x, 0, 0));
}

/// Lowest and highest corner of all boxes.
std::array<double, 6> hull(const NodeBatch& nodes) {
  std::array<double, 6> box{1e300, 1e300, 1e300, -1e300, -1e300, -1e300};
  for (const std::array<double, 6>& b : nodes.boxes)
    for (std::size_t k = 0; k < 3; ++k) {
      box[k] = std::min(box[k], b[k]);
      box[k + 3] = std::max(box[k + 3], b[k + 3]);
    }
  return box;
}

TEST(NodeWalk, EachDepthCoversTheSceneWithAtMostTwiceTheNodes) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended t;
    const std::uint32_t mesh = add(t.scene, sphere(8, 12));
    add_instance(t.scene, mesh, at(5.0));
    add_instance(t.scene, mesh, at(1e6));
    t.update(Policy::selective, layout);
    const auto whole = hull(t.accelerator.nodes_at(0));
    std::size_t before = 1;
    for (std::uint32_t depth = 1; depth < 8; ++depth) {
      const NodeBatch nodes = t.accelerator.nodes_at(depth);
      EXPECT_GT(nodes.boxes.size(), before);
      EXPECT_LE(nodes.boxes.size(), 2 * before);
      for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(hull(nodes)[k], whole[k], 0.5);
      before = nodes.boxes.size();
    }
  }
}

TEST(NodeWalk, DamageAndWhatWasRebuiltAreThoseOfTheLastUpdate) {
  Tended t;
  const Geometry g = sphere(24, 32);
  const std::uint32_t mesh = add(t.scene, g);
  t.update(Policy::selective, Layout::flat);
  EXPECT_EQ(t.accelerator.rebuilt_nodes().boxes.size(), 1u) << "the whole tree";
  std::vector<Vec3> bent = g.vertices;
  for (std::size_t i = 0; i < bent.size(); i += 5) bent[i].x += 3.0f * float(i % 7);
  t.scene.set_vertices(mesh, bent);
  t.accelerator.note_rays(1);
  t.update(Policy::selective, Layout::flat);
  const NodeBatch root = t.accelerator.nodes_at(0);
  EXPECT_GT(root.damage[0], 0.05);
  EXPECT_EQ(root.rebuilt[0] != 0, t.accelerator.rebuilt_nodes().boxes.size() > 0);
  for (int f = 0; f < 4; ++f) {
    bent[0].x += 0.5f;
    t.scene.set_vertices(mesh, bent);
    t.accelerator.note_rays(100'000'000);
    t.update(Policy::selective, Layout::flat);
  }
  EXPECT_LT(t.accelerator.nodes_at(0).damage[0], root.damage[0]) << "mended";
}

}  // namespace
}  // namespace regraft::test
