#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "accel/tended.h"
#include "catalogue/motions.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

TEST(Policies, TheTopTreeIsMendedLikeAnyOther) {
  for (const Policy policy : all_policies) {
    Tended t;
    const std::uint32_t mesh = add(t.scene, sphere(6, 8));
    std::vector<std::uint32_t> ids;
    for (std::size_t i = 1; i < 300; ++i) ids.push_back(add_instance(t.scene, mesh, Mat4d(1.0)));
    std::uint64_t mended = 0;
    for (int f = 0; f < 8; ++f) {
      // Every tenth goes its own way, far through the others.
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const Vec3d at =
            8.0 * in_a_grid(i) + (i % 10 == 0 ? anywhere(i, 1, 8.0) * double(f) : Vec3d(0));
        t.scene.set_transform(ids[i], glm::translate(Mat4d(1.0), at));
      }
      t.accelerator.note_rays(3000);
      mended += t.update(policy).pairs_restructured;
    }
    if (policy == Policy::selective) {
      EXPECT_GT(mended, 0u);
    }
    EXPECT_EQ(t.differences(1, 48), "") << name(policy);
  }
}

TEST(Policies, LayoutsCanBeExchangedAtAnyTime) {
  Tended t;
  const std::uint32_t mesh = add(t.scene, torus(12, 16, 0.4));
  add_instance(t.scene, mesh, glm::scale(Mat4d(1.0), Vec3d(1, 2, 0)));
  for (const Layout layout : {Layout::flat, Layout::two_level, Layout::flat, Layout::two_level}) {
    t.update(Policy::selective, layout);
    EXPECT_EQ(t.differences(1, 48), "");
  }
}

}  // namespace
}  // namespace regraft::test
