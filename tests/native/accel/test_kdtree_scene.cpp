#include "regraft/accel/kdtree_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "kdtree/stand.h"
#include "regraft/accel/accelerator.h"
#include "regraft/accel/structure_choice.h"
#include "regraft/kdtree/statistics.h"
#include "trace/scene_oracle.h"

namespace regraft::test {
namespace {

using accel::Structure;

Mat4d at(const Vec3d& p) {
  return glm::translate(Mat4d(1.0), p);
}

/// A row of 24 balls on a floor, kept in a k-d tree.
struct Row {
  Scene scene;
  accel::Accelerator accelerator;
  accel::UpdateStatistics statistics;
  std::uint32_t ball, floor;

  Row() {
    floor = add_mesh(scene, floor_grid(20, 40.0f));
    add_instance(scene, floor, at({0, 0, -1}));
    ball = add_mesh(scene, sphere(8, 10));
    for (int i = 0; i < 24; ++i) add_instance(scene, ball, at({3.0 * i - 36.0, 0, 0}));
    update();
  }

  void update(accel::Policy policy = accel::Policy::automatic) {
    accel::UpdateOptions options;
    options.structure = Structure::kdtree;
    options.policy = policy;
    statistics = accelerator.update(scene, scene.take_changes(), options, 4, pool(2));
    ASSERT_EQ(accelerator.validate(scene), "");
  }
  const kdtree::KdTree& tree() const { return *accelerator.view().kdtree; }
  std::string differences(std::uint64_t seed) const {
    const std::vector<Ray> rays = nasty_rays(SceneOracle(scene), seed, 96);
    return difference(accelerator.view(), 4, rays, hits_anew(scene, rays));
  }
};

TEST(KdtreeScene, OnlyCellsThatMetWhatMovedAreForgotten) {
  Row row;
  row.tree().complete(pool(2));
  const auto before = planes(row.tree());
  const kdtree::KdTree* const tree = &row.tree();
  row.scene.set_transform(12, at({-3.0, 0.5, 0.0}));
  row.update();
  EXPECT_EQ(&row.tree(), tree);
  const auto after = planes(row.tree());
  EXPECT_GT(after.size(), before.size() / 2);
  EXPECT_LT(after.size(), before.size());
  EXPECT_TRUE(std::includes(before.begin(), before.end(), after.begin(), after.end()));
  EXPECT_EQ(row.differences(1), "");
  row.tree().complete(pool(2));
  EXPECT_EQ(row.accelerator.validate(row.scene), "");
}

TEST(KdtreeScene, HitsStayRightOverManyMovesAndADeformation) {
  Row row;
  ASSERT_EQ(row.differences(2), "");
  Random random(3);
  for (int frame = 0; frame < 12; ++frame) {
    for (int k = 0; k < 3; ++k) {
      const auto who = std::uint32_t(random.uniform(1.0, 24.9));
      row.scene.set_transform(
          who, glm::rotate(at(random.in_box(8.0)), random.uniform(0, 6), random.way()));
    }
    if (frame == 6)
      row.scene.set_vertices(row.floor, floor_grid(20, 40.0f).moved({0, 0, 0.5}).vertices);
    row.update();
    ASSERT_EQ(row.differences(4 + std::uint64_t(frame)), "") << frame;
  }
}

TEST(KdtreeScene, AFreshTreeIsBuiltWhenAskedForOrWhenTheSceneOutgrowsIt) {
  Row row;
  row.tree().complete(pool(2));
  row.scene.set_transform(12, at({-3.0, 0.5, 0.0}));
  row.update(accel::Policy::rebuild);
  EXPECT_EQ(kdtree::measure(row.tree()).nodes(), 0u);
  row.tree().complete(pool(2));
  row.scene.set_transform(12, at({500.0, 0, 0}));
  row.update();
  EXPECT_EQ(kdtree::measure(row.tree()).nodes(), 0u);
  EXPECT_EQ(row.differences(5), "");
}

/// Instances whose meshes were read.
std::set<std::uint32_t> looked_into(const Watched& watched) {
  std::set<std::uint32_t> instances;
  for (const auto& [kind, object, node] : watched.opened())
    if (kind == accel::SceneHierarchy::mesh_node) instances.insert(object);
  return instances;
}

TEST(KdtreeScene, MeshesThatNoRayComesNearAreBoundedAndNotRead) {
  Stand stand;
  const Geometry ball = sphere(8, 10);
  for (int i = 0; i < 128; ++i) stand.add(ball, at({4.0 * (i % 16), 4.0 * (i / 16), 0}));
  const std::vector<Ray> rays = {
      {{0.1, 0.2, 5.0}}, {{4.1, 0.2, 5.0}}, {{0.1, -5.0, 0.1}, {0, 1, 0}}};
  for (int frame = 0; frame < 3; ++frame) {
    const Watched watched(stand.hierarchy());
    const kdtree::KdTree tree(watched, {}, pool(2));
    EXPECT_EQ(stand.differences(tree, rays), "") << frame;
    const std::size_t read = looked_into(watched).size();
    EXPECT_GT(read, 1u) << frame;
    EXPECT_LT(read, 48u) << frame;
    // All deform; the boxes of all are new.
    const double size = 1.2 + 0.1 * frame;
    for (std::uint32_t mesh = 0; mesh < 128; ++mesh)
      stand.scene.set_vertices(mesh,
                               ball.mapped([&](const Vec3d& p) { return size * p; }).vertices);
  }
}

TEST(KdtreeScene, TrianglesThatCannotBeHitAreInNoCellWhereverTheirOtherCornersAre) {
  Row row;
  Geometry holed = floor_grid(20, 40.0f);
  for (std::size_t v = 0; v < holed.vertices.size(); v += 7) holed.vertices[v].z = nan;
  row.scene.set_vertices(row.floor, holed.vertices);
  row.update();
  EXPECT_EQ(row.differences(6), "");
  row.tree().complete(pool(2));
  EXPECT_EQ(row.accelerator.validate(row.scene), "");
}

TEST(StructureChoice, CountsWhatIsInTheWindow) {
  Scene scene;
  const std::uint32_t ball = add_mesh(scene, sphere(16, 16));
  for (const double x : {-20.0, 0.0, 20.0, 40.0}) add_instance(scene, ball, at({x, 0, -10}));
  Camera camera;
  EXPECT_NEAR(accel::share_in_view(scene, camera), 0.25, 1e-9);
  camera.camera_to_world = at({0, 0, -30});
  EXPECT_EQ(accel::share_in_view(scene, camera), 0.0);
  camera.kind = CameraKind::orthographic;
  camera.window = {-30, 30, -30, 30};
  EXPECT_NEAR(accel::share_in_view(scene, camera), 0.75, 1e-9);
  camera.kind = CameraKind::equirectangular;
  EXPECT_EQ(accel::share_in_view(scene, camera), 1.0);
}

TEST(StructureChoice, AKdTreeIsForSingleFramesOfHugeScenesLittleOfWhichIsSeen) {
  Scene scene;
  add_instance(scene, add_mesh(scene, floor_grid(750, 750.0f)));
  accel::UpdateOptions options;
  options.frames_left = 1;
  Camera near;
  near.camera_to_world = at({0, 0, 20});
  const auto choice = [&] {
    return accel::choose_structure(scene, options, Structure::automatic).structure;
  };
  EXPECT_EQ(choice(), Structure::bvh);
  options.camera = near;
  EXPECT_EQ(choice(), Structure::kdtree);
  options.frames_left = 2;
  EXPECT_EQ(choice(), Structure::bvh);
  options.frames_left = 1;
  options.camera->camera_to_world = at({0, 0, 5000});
  EXPECT_EQ(choice(), Structure::bvh);
  options.camera = near;
  EXPECT_EQ(accel::choose_structure(scene, options, Structure::bvh).structure, Structure::bvh);
  options.structure = Structure::bvh;
  EXPECT_EQ(choice(), Structure::bvh);
}

}  // namespace
}  // namespace regraft::test
