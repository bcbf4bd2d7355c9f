#include <gtest/gtest.h>

#include <functional>
#include <glm/gtc/matrix_transform.hpp>

#include "accel/tended.h"

namespace regraft::test {
namespace {

using accel::Layout;
using accel::Policy;

constexpr Policy all_policies[] = {
    Policy::automatic, Policy::refit,     Policy::rebuild,         Policy::lm,
    Policy::rtdeform,  Policy::selective, Policy::selective_rotate};

/// Where triangle i of `count` is in a frame.
using Motion = std::function<Vec3d(std::size_t i, int frame)>;

Vec3d grid(std::size_t i) {
  return {double(i % 10), double(i / 10 % 10), double(i / 100)};
}

Geometry shards(std::size_t count, const Motion& motion, int frame) {
  Geometry g;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d at = motion(i, frame);
    const auto first = std::uint32_t(g.vertices.size());
    for (const Vec3d& corner : {Vec3d(0, 0, 0), Vec3d(0.3, 0.1, 0), Vec3d(0, 0.2, 0.3)})
      g.vertices.emplace_back(at + corner);
    g.triangles.emplace_back(first, first + 1, first + 2);
  }
  return g;
}

Vec3d anywhere(std::size_t i, std::uint64_t seed, double half) {
  Random random(seed * 7919 + i);
  return random.in_box(half);
}

/// Catalogue G of the specification.
const std::pair<const char*, Motion> stiff_motions[] = {
    {"explosion", [](std::size_t i, int f) { return grid(i) + anywhere(i, 1, 3.0) * double(f); }},
    {"two swap", [](std::size_t i, int f) { return grid(f > 2 && i < 2 ? (1 - i) * 399 : i); }},
    {"cyclic", [](std::size_t i, int f) { return grid((i + std::size_t(37 * f)) % 400); }},
    {"teleport",
     [](std::size_t i, int f) { return grid(i) + Vec3d(f == 2 && i == 7 ? 1e6 : 0.0); }},
    {"collapse", [](std::size_t i, int f) { return grid(i) * (f == 2 ? 1e-12 : 1.0); }},
    {"twist",
     [](std::size_t i, int f) {
       const Vec3d p = grid(i) - Vec3d(4.5, 4.5, 0);
       const double a = f * p.z;
       return Vec3d(std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y,
                    p.z);
     }},
    {"half turns",
     [](std::size_t i, int f) { return grid(i) * Vec3d(f % 2 == 0 ? 100.0 : -100.0, 1, 1); }},
    {"growth", [](std::size_t i, int f) { return grid(i) * std::exp2(12.0 * f); }},
    {"one at 1e20", [](std::size_t i, int f) { return f == 2 && i == 3 ? Vec3d(1e20) : grid(i); }},
    {"thrash", [](std::size_t i, int f) { return f % 2 == 0 ? grid(i) : anywhere(i, 2, 5.0); }},
    {"anything", [](std::size_t i, int f) { return anywhere(i, 3 + std::uint64_t(f), 5.0); }},
};

TEST(Policies, AllFindTheSameHitsHoweverThingsMove) {
  for (const auto& [what, motion] : stiff_motions)
    for (const Policy policy : all_policies)
      for (const Layout layout : {Layout::two_level, Layout::flat}) {
        Tended t;
        t.accelerator.note_rays(100'000'000);  // so many that everything is worth mending
        const std::uint32_t mesh = add(t.scene, shards(400, motion, 0));
        for (int f = 0; f < 5; ++f) {
          t.scene.set_vertices(mesh, shards(400, motion, f).vertices);
          t.update(policy, layout);
        }
        EXPECT_EQ(t.differences(1, 48), "") << what << " " << name(policy) << name(layout);
      }
}

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
        const Vec3d at = 8.0 * grid(i) + (i % 10 == 0 ? anywhere(i, 1, 8.0) * double(f) : Vec3d(0));
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

TEST(Policies, SelectiveKeepsATreeNearlyAsGoodAsNew) {
  for (const Layout layout : {Layout::two_level, Layout::flat}) {
    Tended mended, refitted;
    const Motion& explosion = stiff_motions[0].second;
    const std::uint32_t mesh = add(mended.scene, shards(1000, explosion, 0));
    add(refitted.scene, shards(1000, explosion, 0));
    for (int f = 0; f < 20; ++f) {
      const auto next = shards(1000, explosion, f).vertices;
      for (Tended* t : {&mended, &refitted}) t->scene.set_vertices(mesh, next);
      mended.accelerator.note_rays(100'000'000);
      mended.update(Policy::selective, layout);
      refitted.update(Policy::refit, layout);
    }
    EXPECT_LT(mended.accelerator.quality(mended.scene, true, pool(2)).cost_ratio, 1.2);
    EXPECT_GT(refitted.accelerator.quality(refitted.scene, true, pool(2)).cost_ratio, 2.0);
  }
}

TEST(Policies, AStaticSceneIsLeftAlone) {
  for (const Policy policy : all_policies) {
    Tended t;
    const std::uint32_t mesh = add(t.scene, sphere(16, 24));
    t.update(policy);
    for (int f = 0; f < 20; ++f) {
      // The same positions: nothing that changed, hence nothing to do.
      t.scene.set_vertices(mesh, sphere(16, 24).vertices);
      const auto s = t.update(policy);
      EXPECT_EQ(s.nodes_refitted + s.nodes_rebuilt + s.pairs_considered + s.pairs_restructured, 0u);
    }
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
