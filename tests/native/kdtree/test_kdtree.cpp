#include "regraft/kdtree/kdtree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>
#include <thread>

#include "kdtree/stand.h"
#include "regraft/kdtree/statistics.h"
#include "regraft/kdtree/validate.h"
#include "trace/scene_oracle.h"

namespace regraft::test {
namespace {

using kdtree::Config;
using kdtree::KdTree;

Mat4d at(const Vec3d& p) {
  return glm::translate(Mat4d(1.0), p);
}

Config lazy() {
  return {};
}

Config eager() {
  Config config;
  config.lazy = false;
  return config;
}

/// Instances turned anyhow, a closed mesh and a soup.
void furnish(Stand& stand) {
  Random random(11);
  const std::uint32_t mesh = add_mesh(stand.scene, sphere(10, 14));
  for (int i = 0; i < 5; ++i)
    add_instance(stand.scene, mesh,
                 glm::rotate(at(random.in_box(2.0)), random.uniform(0.0, 6.0), random.way()));
  stand.add(soup(150, 5, 2.0, 0.6));
}

TEST(KdTree, WithoutRaysOnlyTheRootExists) {
  Stand stand;
  furnish(stand);
  const Watched watched(stand.hierarchy());
  const KdTree tree(watched, lazy(), pool(1));
  const kdtree::Statistics s = kdtree::measure(tree);
  EXPECT_EQ(s.nodes(), 0u);
  EXPECT_EQ(s.unbuilt, 1u);
  EXPECT_EQ(s.built_fraction, 0.0);
  EXPECT_TRUE(watched.opened().empty());
  EXPECT_EQ(kdtree::validate(tree), "");
}

TEST(KdTree, EveryConfigurationHitsWhatBruteForceHits) {
  Stand stand;
  furnish(stand);
  const HierarchyView& view = stand.hierarchy();
  const std::vector<Ray> rays = nasty_rays(SceneOracle(stand.scene), 1, 160);
  for (Config config : all_configurations())
    for (const std::uint32_t refine_to : {10u, 50u, 500u}) {
      config.refine_to = refine_to;
      const KdTree tree(view, config, pool(2));
      ASSERT_EQ(stand.differences(tree, rays), "") << name(config) << ' ' << refine_to;
      ASSERT_EQ(kdtree::validate(tree), "") << name(config) << ' ' << refine_to;
      tree.complete(pool(2));
      ASSERT_EQ(kdtree::validate(tree), "") << name(config) << ' ' << refine_to;
    }
}

TEST(KdTree, ALazyTreeIsAPartOfTheEagerOne) {
  Stand stand;
  furnish(stand);
  const HierarchyView& view = stand.hierarchy();
  for (const auto refine : {kdtree::Refine::fifo, kdtree::Refine::area}) {
    Config config = lazy();
    config.refine = refine;
    const KdTree part(view, config, pool(1));
    EXPECT_EQ(stand.differences(part, crossing_rays(3, 20, 1.0)), "");
    config.lazy = false;
    const KdTree whole(view, config, pool(2));
    const auto some = planes(part), all = planes(whole);
    EXPECT_GT(some.size(), 10u);
    EXPECT_LT(some.size(), all.size());
    EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
    part.complete(pool(2));
    EXPECT_EQ(planes(part), all);
  }
}

TEST(KdTree, WhatIsOpenedDependsOnTheRaysAlone) {
  Stand stand;
  furnish(stand);
  const HierarchyView& view = stand.hierarchy();
  std::vector<Ray> rays = crossing_rays(4, 128, 0.4);
  const auto opened = [&](unsigned threads, Entry entry) {
    const Watched watched(view);
    const KdTree tree(watched, lazy(), pool(1));
    const trace::TraceView shown = stand.view(tree);
    std::vector<std::thread> crew;
    for (unsigned t = 0; t < threads; ++t)
      crew.emplace_back([&, t] {
        const trace::Tracer tracer(shown, simd::Isa::scalar);
        const std::size_t first = rays.size() * t / threads;
        const std::size_t last = rays.size() * (t + 1) / threads;
        closest_hits(tracer, std::span(rays).subspan(first, last - first), entry);
      });
    for (std::thread& t : crew) t.join();
    return std::pair(watched.opened(), planes(tree));
  };
  const auto once = opened(1, Entry::single);
  EXPECT_FALSE(once.first.empty());
  EXPECT_EQ(once, opened(8, Entry::single));
  EXPECT_EQ(once, opened(1, Entry::packet));
  std::reverse(rays.begin(), rays.end());
  EXPECT_EQ(once, opened(3, Entry::packet));
}

TEST(KdTree, ManyThreadsBuildOneTreeAndHitTheSame) {
  Stand stand;
  furnish(stand);
  const std::vector<Ray> rays = crossing_rays(5, 400, 2.0);
  const HierarchyView& view = stand.hierarchy();
  const std::vector<Found> wanted = hits_anew(stand.scene, rays);
  for (int round = 0; round < 4; ++round) {
    const KdTree tree(view, lazy(), pool(1));
    const trace::TraceView shown = stand.view(tree);
    std::vector<std::string> wrong(8);
    std::vector<std::thread> crew;
    for (std::string& error : wrong)
      crew.emplace_back([&] {
        const trace::Tracer tracer(shown, simd::Isa::scalar);
        const std::vector<Found> found = closest_hits(tracer, rays, Entry::packet);
        if (found != wanted) error = "another hit";
      });
    for (std::thread& t : crew) t.join();
    for (const std::string& error : wrong) EXPECT_EQ(error, "");
    EXPECT_EQ(kdtree::validate(tree), "");
  }
}

TEST(KdTree, HiddenGeometryCostsALogarithm) {
  std::vector<std::size_t> opened;
  for (const int copies : {1, 2, 4, 8}) {
    Stand stand;
    stand.add(sphere(16, 16));
    // Rays go at the sphere only; what is hidden lies far to the side.
    const std::uint32_t mesh = add_mesh(stand.scene, soup(256, 6, 1.0, 0.3));
    for (int i = 0; i < 16 * copies; ++i)
      add_instance(stand.scene, mesh, at({20.0 + 3 * (i % 8), 3.0 * (i / 8), 0}));
    const Watched watched(stand.hierarchy());
    const KdTree tree(watched, lazy(), pool(1));
    std::vector<Ray> rays;
    Random random(8);
    for (int i = 0; i < 256; ++i) {
      const Vec3d from(random.uniform(-1, 1), random.uniform(-1, 1), 5);
      rays.push_back({from, {0, 0, -1}});
    }
    ASSERT_EQ(stand.differences(tree, rays), "");
    opened.push_back(watched.opened().size());
  }
  for (std::size_t i = 1; i < opened.size(); ++i)
    EXPECT_LE(opened[i], opened[i - 1] + 40) << "at twice the hidden geometry";
}

TEST(KdTree, ReferencesAreAtLeastThePrimitivesAndAtMostTheBudget) {
  Stand stand;
  stand.add(soup(400, 7, 1.0, 0.3));
  Config config = eager();
  config.cost.intersect = 10.0;
  const KdTree free(stand.hierarchy(), config, pool(1));
  config.references_per_primitive = 1.0;
  const KdTree bound(free.view(), config, pool(1));
  EXPECT_GE(kdtree::measure(bound).references, 400u);
  EXPECT_LE(kdtree::measure(bound).references, 2 * (400u + 64u));
  EXPECT_LT(kdtree::measure(bound).references, kdtree::measure(free).references);
  EXPECT_EQ(stand.differences(bound, crossing_rays(7, 64, 1.0)), "");
}

TEST(KdTree, DuplicatesOfATriangleAreOneLargeLeafThatIsReported) {
  Stand stand;
  Geometry g = triangle({0, 0, 0}, {1, 0, 0.3f}, {0, 1, 0.7f});
  g.triangles.resize(3000, g.triangles[0]);
  stand.add(g);
  const KdTree tree(stand.hierarchy(), eager(), pool(1));
  const kdtree::Statistics s = kdtree::measure(tree);
  EXPECT_EQ(s.large_leaves, 1u);
  EXPECT_EQ(s.largest_leaf, 3000u);
  EXPECT_LE(s.references, 4 * 3000u);
  const Ray ray{{0.2, 0.2, 5}, {0, 0, -1}};
  EXPECT_EQ(stand.differences(tree, std::span(&ray, 1)), "");
}

TEST(KdTree, ANodeWhoseBuildingFailedCanBeBuiltLater) {
  Stand stand;
  furnish(stand);
  Watched watched(stand.hierarchy());
  const KdTree tree(watched, lazy(), pool(1));
  watched.fail_at(3);
  const std::vector<Ray> rays = crossing_rays(9, 64, 1.0);
  EXPECT_THROW(stand.differences(tree, rays), std::runtime_error);
  watched.fail_at(std::size_t(-1));
  EXPECT_EQ(stand.differences(tree, rays), "");
  EXPECT_EQ(kdtree::validate(tree), "");
}

TEST(KdTree, StatisticsTellHowMuchIsBuilt) {
  Stand stand;
  furnish(stand);
  const KdTree tree(stand.hierarchy(), lazy(), pool(1));
  const std::vector<Ray> rays = crossing_rays(10, 4, 1.0);
  ASSERT_EQ(stand.differences(tree, rays), "");
  const kdtree::Statistics part = kdtree::measure(tree);
  EXPECT_GT(part.built_fraction, 0.0);
  EXPECT_LT(part.built_fraction, 1.0);
  EXPECT_GT(part.unbuilt, 0u);
  tree.complete(pool(1));
  const kdtree::Statistics all = kdtree::measure(tree);
  EXPECT_EQ(all.built_fraction, 1.0);
  EXPECT_EQ(all.unbuilt, 0u);
  EXPECT_EQ(all.leaves, all.inner + 1);
  EXPECT_GE(all.bytes, all.nodes() * sizeof(kdtree::Node) + 8 * all.references);
  const double n = tree.builder().weight();
  EXPECT_GT(all.quality(n, {}), 0.0);
  EXPECT_LT(all.quality(n, {}), 1.0);
}

TEST(KdTree, QualityIsNotDefinedForOnePrimitive) {
  Stand stand;
  stand.add(triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const KdTree tree(stand.hierarchy(), eager(), pool(1));
  EXPECT_TRUE(std::isnan(kdtree::measure(tree).quality(1.0, {})));
  EXPECT_EQ(kdtree::measure(tree).nodes(), 1u);
}

TEST(KdTree, ConfigurationsAreNamedByWhatIsOn) {
  std::set<std::string> names;
  for (const Config& config : all_configurations()) names.emplace(name(config));
  EXPECT_EQ(names.size(), 8u);
  EXPECT_TRUE(names.count("eager") == 1 && names.count("lazy+scan+hierarchy") == 1);
}

}  // namespace
}  // namespace regraft::test
