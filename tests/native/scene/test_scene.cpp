#include "regraft/scene/scene.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "scene/shapes.h"

namespace regraft {
namespace {

using test::refusal;
using test::Square;
using Ids = std::vector<std::uint32_t>;

Mat4d moved_by(double x) {
  Mat4d m(1.0);
  m[3][0] = x;
  return m;
}

Instance of(std::uint32_t mesh, const char* name = "") {
  Instance instance;
  instance.mesh = mesh;
  instance.name = name;
  return instance;
}

class SceneTest : public testing::Test {
 protected:
  SceneTest() {
    mesh = scene.add_mesh(square.data(), "Sign");
    instance = scene.add_instance(of(mesh, "Left"));
    scene.take_changes();
  }

  Square square;
  Scene scene;
  std::uint32_t mesh = 0;
  std::uint32_t instance = 0;
};

TEST_F(SceneTest, KeepsWhatItIsGiven) {
  EXPECT_EQ(scene.meshes()[mesh].vertices, square.vertices);
  EXPECT_EQ(scene.meshes()[mesh].triangles, square.triangles);
  EXPECT_EQ(scene.meshes()[mesh].instance_count, 1u);
  EXPECT_EQ(scene.instances()[instance].name, "Left");
  EXPECT_TRUE(scene.instances()[instance].alive);
}

TEST_F(SceneTest, NewThingsAreToldOnce) {
  const std::uint32_t other = scene.add_mesh(square.data(), "Other");
  scene.add_instance(of(other));
  const ChangeSet set = scene.take_changes();
  EXPECT_EQ(set.added_meshes, Ids{other});
  EXPECT_TRUE(set.instance_set_changed);
  EXPECT_TRUE(scene.changes().empty());
}

TEST_F(SceneTest, NewPositionsAreADeformation) {
  square.vertices[2].z = 0.5f;
  scene.set_vertices(mesh, square.vertices);
  EXPECT_EQ(scene.take_changes().deformed_meshes, Ids{mesh});
  EXPECT_EQ(scene.meshes()[mesh].vertices[2].z, 0.5f);
}

TEST_F(SceneTest, PositionsEqualBitForBitAreNoChange) {
  scene.set_vertices(mesh, square.vertices);
  EXPECT_TRUE(scene.changes().empty());
  square.vertices[0].x = -0.0f;
  scene.set_vertices(mesh, square.vertices);
  EXPECT_EQ(scene.changes().deformed_meshes, Ids{mesh});
}

TEST_F(SceneTest, PositionsThatAreNotFiniteAreTaken) {
  square.vertices[0].x = std::numeric_limits<float>::quiet_NaN();
  scene.set_vertices(mesh, square.vertices);
  EXPECT_EQ(scene.take_changes().deformed_meshes, Ids{mesh});
  scene.set_vertices(mesh, square.vertices);
  EXPECT_TRUE(scene.changes().empty());
}

TEST_F(SceneTest, AnotherNumberOfPositionsIsRefusedAndChangesNothing) {
  square.vertices.pop_back();
  EXPECT_EQ(refusal([&] { scene.set_vertices(mesh, square.vertices); }),
            "mesh 0 \"Sign\": 3 vertices, 4 wanted; set_mesh changes their number");
  EXPECT_TRUE(scene.changes().empty());
}

TEST_F(SceneTest, ANewTopologyReplacesEverything) {
  square.triangles.pop_back();
  square.slots = {7};
  square.normal_ids = square.triangles;
  scene.set_mesh(mesh, square.data());
  EXPECT_EQ(scene.take_changes().retopologised_meshes, Ids{mesh});
  EXPECT_EQ(scene.meshes()[mesh].triangles.size(), 1u);
  EXPECT_EQ(scene.meshes()[mesh].slots, square.slots);
  EXPECT_EQ(scene.meshes()[mesh].normal_count, 3u);
  EXPECT_EQ(scene.meshes()[mesh].name, "Sign");
  EXPECT_EQ(scene.meshes()[mesh].instance_count, 1u);
}

TEST_F(SceneTest, AWrongTopologyIsRefusedAndChangesNothing) {
  square.triangles[0].x = 99;
  EXPECT_EQ(refusal([&] { scene.set_mesh(mesh, square.data()); }),
            "mesh 0 \"Sign\": triangle 0 names vertex 99, but there are 4 vertices");
  EXPECT_EQ(refusal([&] { scene.add_mesh(square.data(), "New"); }),
            "mesh 1 \"New\": triangle 0 names vertex 99, but there are 4 vertices");
  EXPECT_TRUE(scene.changes().empty());
  EXPECT_EQ(scene.meshes()[mesh].triangles[0].x, 0u);
  EXPECT_EQ(scene.meshes().size(), 1u);
}

TEST_F(SceneTest, AMeshWithoutTrianglesOrVerticesIsFine) {
  EXPECT_EQ(scene.add_mesh({}, "Empty"), 1u);
  Square points;
  points.triangles.clear();
  EXPECT_EQ(scene.add_mesh(points.data(), "Points"), 2u);
}

TEST_F(SceneTest, AMeshInUseCannotBeRemoved) {
  EXPECT_EQ(refusal([&] { scene.remove_mesh(mesh); }),
            "mesh 0 \"Sign\" cannot be removed: 1 instances use it");
  scene.remove_instance(instance);
  scene.remove_mesh(mesh);
  EXPECT_EQ(scene.changes().removed_meshes, Ids{mesh});
  EXPECT_FALSE(scene.meshes()[mesh].alive);
  EXPECT_EQ(scene.meshes()[mesh].bytes(), 0u);
}

TEST_F(SceneTest, DeadAndUnknownIdsAreNamed) {
  scene.remove_instance(instance);
  scene.remove_mesh(mesh);
  EXPECT_EQ(refusal([&] { scene.set_vertices(mesh, {}); }), "mesh 0 was removed");
  EXPECT_EQ(refusal([&] { scene.set_mesh(5, {}); }), "mesh 5 does not exist; 1 were ever added");
  EXPECT_EQ(refusal([&] { scene.remove_mesh(0); }), "mesh 0 was removed");
  EXPECT_EQ(refusal([&] { scene.set_visible(0, true); }), "instance 0 was removed");
  EXPECT_EQ(refusal([&] { scene.set_transform(9, Mat4d(1.0)); }),
            "instance 9 does not exist; 1 were ever added");
  EXPECT_EQ(refusal([&] { scene.set_material_list(invalid_id, 0); }),
            "instance 4294967295 does not exist; 1 were ever added");
  EXPECT_EQ(refusal([&] { scene.add_instance(of(0, "Ghost")); }),
            "new instance \"Ghost\": mesh 0 was removed");
}

TEST_F(SceneTest, IdsAreNeverUsedAgain) {
  scene.remove_instance(instance);
  EXPECT_EQ(scene.add_instance(of(mesh)), 1u);
}

TEST_F(SceneTest, AMatrixEqualBitForBitIsNoChange) {
  scene.set_transform(instance, Mat4d(1.0));
  EXPECT_TRUE(scene.changes().empty());
  scene.set_transform(instance, moved_by(2));
  EXPECT_EQ(scene.take_changes().moved_instances, Ids{instance});
  EXPECT_EQ(scene.instances()[instance].object_to_world, moved_by(2));
}

TEST_F(SceneTest, AMatrixThatIsNotFiniteIsTaken) {
  scene.set_transform(instance, Mat4d(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(scene.take_changes().moved_instances, Ids{instance});
}

TEST_F(SceneTest, AProjectiveMatrixIsRefused) {
  Mat4d m(1.0);
  m[0][3] = 0.5;
  EXPECT_EQ(refusal([&] { scene.set_transform(instance, m); }),
            "instance 0 \"Left\": last row of the transform is (0.500000, 0.000000, 0.000000, "
            "1.000000), (0, 0, 0, 1) wanted");
  Instance bad = of(mesh, "Bad");
  bad.object_to_world = m;
  EXPECT_THROW(scene.add_instance(bad), std::invalid_argument);
  EXPECT_TRUE(scene.changes().empty());
}

TEST_F(SceneTest, TheLastRowIsKeptExact) {
  Mat4d m = moved_by(1);
  m[3][3] = 1.0 + 1e-7;
  scene.set_transform(instance, m);
  EXPECT_EQ(scene.instances()[instance].object_to_world, moved_by(1));
}

TEST_F(SceneTest, TransformsInBulkAreAllOrNone) {
  const std::uint32_t second = scene.add_instance(of(mesh));
  scene.take_changes();
  const std::vector<Mat4d> matrices{moved_by(1), moved_by(2)};
  EXPECT_THROW(scene.set_transforms(Ids{instance, 7}, matrices), std::invalid_argument);
  EXPECT_THROW(scene.set_transforms(Ids{instance}, matrices), std::invalid_argument);
  EXPECT_TRUE(scene.changes().empty());
  scene.set_transforms(Ids{second, instance}, matrices);
  EXPECT_EQ(scene.changes().moved_instances, (Ids{second, instance}));
  EXPECT_EQ(scene.instances()[second].object_to_world, moved_by(1));
}

TEST_F(SceneTest, AHiddenInstanceMovesUnseenAndIsRightOnceShown) {
  scene.set_visible(instance, false);
  scene.take_changes();
  scene.set_transform(instance, moved_by(3));
  EXPECT_TRUE(scene.changes().empty());
  scene.set_visible(instance, true);
  EXPECT_EQ(scene.changes().moved_instances, Ids{instance});
  EXPECT_EQ(scene.instances()[instance].object_to_world, moved_by(3));
}

TEST_F(SceneTest, ShowingWhatIsShownIsNoChange) {
  scene.set_visible(instance, true);
  EXPECT_TRUE(scene.changes().empty());
}

TEST_F(SceneTest, InstancesInBulkAreAllOrNone) {
  EXPECT_THROW(scene.add_instances({of(mesh), of(77)}), std::invalid_argument);
  EXPECT_EQ(scene.instances().size(), 1u);
  EXPECT_EQ(scene.meshes()[mesh].instance_count, 1u);
  EXPECT_EQ(scene.add_instances({of(mesh), of(mesh)}), 1u);
  EXPECT_EQ(scene.meshes()[mesh].instance_count, 3u);
  EXPECT_EQ(scene.add_instances({}), 3u);
}

TEST_F(SceneTest, RemovalInBulkIsAllOrNone) {
  const std::uint32_t second = scene.add_instance(of(mesh));
  EXPECT_EQ(refusal([&] {
              scene.remove_instances(Ids{second, instance, instance});
            }),
            "instance 0 \"Left\" cannot be removed twice");
  EXPECT_THROW(scene.remove_instances(Ids{second, 9}), std::invalid_argument);
  EXPECT_EQ(scene.meshes()[mesh].instance_count, 2u);
  scene.remove_instances(Ids{second, instance});
  EXPECT_EQ(scene.meshes()[mesh].instance_count, 0u);
}

TEST_F(SceneTest, GroupsNeedAParentThatExists) {
  const std::uint32_t top = scene.add_group(invalid_id, "Top");
  const std::uint32_t below = scene.add_group(top, "Below");
  EXPECT_EQ(scene.groups()[below].parent, top);
  EXPECT_EQ(refusal([&] { scene.add_group(9, "Lost"); }),
            "group \"Lost\": its parent, group 9, does not exist");
  Instance lost = of(mesh, "Lost");
  lost.group = 5;
  EXPECT_EQ(refusal([&] { scene.add_instance(lost); }),
            "new instance \"Lost\": group 5 does not exist");
}

TEST_F(SceneTest, EqualMaterialListsShareAnId) {
  EXPECT_EQ(scene.material_list({}), 0u);
  const std::uint32_t list = scene.material_list(Ids{2, 0});
  EXPECT_EQ(scene.material_list(Ids{2, 0}), list);
  EXPECT_NE(scene.material_list(Ids{0, 2}), list);
}

TEST_F(SceneTest, MaterialsAreFoundBySlotAndFallBackToTheStandardOne) {
  Material red;
  red.base_color = {1, 0, 0, 1};
  scene.set_materials({Material{}, red});
  scene.set_material_list(instance, scene.material_list(Ids{1, 99}));
  const Instance& placed = scene.instances()[instance];
  EXPECT_EQ(scene.material(placed, 0), red);
  EXPECT_EQ(scene.material(placed, 1), Material{}) << "no such material";
  EXPECT_EQ(scene.material(placed, 2), Material{}) << "no such slot";
  EXPECT_TRUE(scene.changes().empty());
  EXPECT_THROW(scene.set_material_list(instance, 50), std::invalid_argument);
}

TEST_F(SceneTest, BytesGrowWithTheScene) {
  const std::size_t before = scene.bytes();
  scene.add_mesh(square.data(), "");
  EXPECT_GE(scene.bytes(), before + 4 * sizeof(Vec3) + 2 * sizeof(Triangle));
}

}  // namespace
}  // namespace regraft
