#include <gtest/gtest.h>

#include <algorithm>

#include <glm/gtc/matrix_transform.hpp>

#include "trace/bed.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

constexpr Setup kinds[] = {
    {Policy::refit, Layout::two_level},     {Policy::automatic, Layout::two_level},
    {Policy::selective, Layout::two_level}, {Policy::rebuild, Layout::two_level},
    {Policy::refit, Layout::flat},          {Policy::selective, Layout::flat}};

/// Instances of two meshes, here and there.
struct Crowd {
  Bed bed{kinds};
  Random random{3};
  std::uint32_t meshes[2];
  std::vector<std::uint32_t> instances;

  explicit Crowd(std::size_t count) {
    meshes[0] = add_mesh(bed.scene, sphere(4, 5));
    meshes[1] = add_mesh(bed.scene, box({-1, -1, -1}, {1, 1, 1}));
    while (instances.size() < count) come();
    bed.note_rays(100000);
  }
  void come() {
    const Mat4d at = glm::translate(Mat4d(1.0), random.in_box(20.0));
    instances.push_back(add_instance(bed.scene, meshes[random.below(2)], at));
  }
  std::uint32_t any() { return instances[random.below(instances.size())]; }
};

bool is_edited(const accel::UpdateStatistics& s) {
  return std::any_of(s.left_out.begin(), s.left_out.end(), [](const std::string& text) {
    return text.find("not built anew") != std::string::npos;
  });
}

TEST(TreeEdits, WhatComesAndGoesIsPutInAndTakenOutAndHitAsEver) {
  Crowd crowd(80);
  ASSERT_EQ(crowd.bed.problems(1, 64), "");
  for (int frame = 0; frame < 6; ++frame) {
    crowd.bed.scene.set_visible(crowd.any(), frame % 2 == 0);
    crowd.bed.scene.set_transform(crowd.any(),
                                  glm::translate(Mat4d(1.0), crowd.random.in_box(25.0)));
    crowd.come();
    if (frame % 3 == 2) {
      const std::uint32_t gone = crowd.instances.front();
      crowd.instances.erase(crowd.instances.begin());
      crowd.bed.scene.remove_instance(gone);
    }
    crowd.bed.note_rays(100000);
    EXPECT_EQ(crowd.bed.problems(std::uint64_t(frame) + 2, 64), "") << frame;
    for (const test::Setup& setup : kinds) {
      const bool builds = setup.policy == Policy::rebuild;
      EXPECT_EQ(is_edited(crowd.bed.statistics(setup)), !builds) << setup << ", frame " << frame;
      EXPECT_EQ(crowd.bed.statistics(setup).nodes_rebuilt <
                    crowd.bed.statistics({Policy::rebuild, setup.layout}).nodes / 2,
                !builds)
          << setup << ", frame " << frame;
    }
  }
}

TEST(TreeEdits, WhereMostComesOrGoesInTheEndAllIsBuiltAnew) {
  Crowd crowd(80);
  ASSERT_EQ(crowd.bed.update(), "");
  int edited = 0;
  for (int frame = 0; frame < 6; ++frame) {
    for (int i = 0; i < 8; ++i) crowd.come();
    ASSERT_EQ(crowd.bed.update(), "");
    edited += is_edited(crowd.bed.statistics(kinds[0]));
  }
  EXPECT_EQ(edited, 5);
  for (const std::uint32_t id : crowd.instances) crowd.bed.scene.set_visible(id, false);
  EXPECT_EQ(crowd.bed.problems(1, 32), "");
  EXPECT_FALSE(is_edited(crowd.bed.statistics(kinds[0])));
}

TEST(TreeEdits, OnlyAMeshWithOtherTrianglesIsTakenOutOfTheFlatTreeAndPutBack) {
  Bed bed(kinds);
  std::vector<std::uint32_t> meshes;
  for (int i = 0; i < 40; ++i) {
    const Mat4d at = glm::translate(Mat4d(1.0), {3.0 * i, 0, 0});
    meshes.push_back(bed.add(sphere(6, 8), at));
  }
  ASSERT_EQ(bed.update(), "");
  for (int frame = 0; frame < 3; ++frame) {
    bed.scene.set_mesh(meshes[5], sphere(frame % 2 == 0 ? 4u : 7u, 8).data());
    bed.deform(meshes[6], sphere(6, 8).scaled(1.0 + frame));
    EXPECT_EQ(bed.problems(std::uint64_t(frame) + 1, 64), "");
    const accel::UpdateStatistics& s = bed.statistics({Policy::refit, Layout::flat});
    EXPECT_TRUE(is_edited(s));
    EXPECT_LT(s.nodes_rebuilt, s.nodes / 4);
  }
}

}  // namespace
}  // namespace regraft::test
