#pragma once

// The scenes of the k-d tree's tables; made by formula, the same on every machine.

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "bench_scenes.h"
#include "regraft/scene/scene.h"

namespace regraft::bench {

/// Looks from `eye` towards `target`, 60 degrees wide, y-up pictures in a z-up world.
struct View {
  const char* name;
  Vec3d eye, target;

  Vec3d direction(int x, int y, int size) const {
    const Vec3d forward = glm::normalize(target - eye);
    const Vec3d right = glm::normalize(glm::cross(forward, Vec3d(0, 0, 1)));
    const Vec3d up = glm::cross(right, forward);
    const double u = 2.0 * (x + 0.5) / size - 1.0;
    const double v = 1.0 - 2.0 * (y + 0.5) / size;
    return forward + 0.577 * (u * right + v * up);
  }
};

struct KdtreeScene {
  const char* name = "";
  Scene scene;
  std::vector<View> views;  ///< near, far
  std::size_t triangles = 0;

  std::uint32_t mesh(const Triangles& mesh, const char* what) {
    return scene.add_mesh({mesh.vertices, mesh.triangles, {}, {}}, what);
  }
  void add(std::uint32_t mesh_id, std::uint32_t group, const Mat4d& frame) {
    Instance instance;
    instance.mesh = mesh_id;
    instance.group = group;
    instance.object_to_world = frame;
    scene.add_instance(instance);
    triangles += scene.meshes()[mesh_id].triangles.size();
  }
};

inline Mat4d placed(const Vec3d& at, double turn = 0.0, double scale = 1.0) {
  const Mat4d moved = glm::rotate(glm::translate(Mat4d(1.0), at), turn, Vec3d(0, 0, 1));
  return glm::scale(moved, Vec3d(scale));
}

/// A wavy closed tube of about `count` triangles, radius about 1, from z = 0 to `height`.
inline Triangles tube(std::size_t count, float height) {
  const auto around = std::max<std::uint32_t>(6, std::uint32_t(std::sqrt(double(count) / 2.0)));
  const auto along = std::max<std::uint32_t>(1, std::uint32_t(count / (2 * around)));
  Triangles mesh;
  for (std::uint32_t j = 0; j <= along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const float t = 6.2831853f * float(i) / float(around), s = float(j) / float(along);
      const float radius = 0.8f + 0.2f * std::sin(9.0f * s) * std::cos(3.0f * t);
      mesh.vertices.emplace_back(radius * std::cos(t), radius * std::sin(t), height * s);
    }
  for (std::uint32_t j = 0; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around;
      mesh.triangles.emplace_back(a, b, a + around);
      mesh.triangles.emplace_back(b, b + around, a + around);
    }
  return mesh;
}

/// A yard between four wings of 4 floors and 16 bays; every bay carries a window, a balcony and a
/// plant. `copies` yards in a row, the first in view, the others behind the near view's back.
inline KdtreeScene courtyard(std::size_t triangles, int copies = 1) {
  KdtreeScene made;
  made.name = "courtyard";
  constexpr int wings = 4, floors = 4, bays = 16;
  const std::size_t bay = triangles / (wings * floors * bays);
  const std::uint32_t wall = made.mesh(sheet(bay / 2, 0.0f), "wall");
  const std::uint32_t plant = made.mesh(tube(bay / 2, 1.5f), "plant");
  const std::uint32_t ground = made.mesh(sheet(64, 0.0f), "ground");
  for (int copy = 0; copy < copies; ++copy) {
    const Vec3d centre(0.0, -60.0 * copy, 0.0);
    const std::uint32_t yard = made.scene.add_group(invalid_id, "yard");
    made.add(ground, yard, placed(centre, 0.0, 25.0) * glm::scale(Mat4d(1.0), Vec3d(1, 1, 0)));
    for (int w = 0; w < wings; ++w) {
      const std::uint32_t wing = made.scene.add_group(yard, "wing");
      const double turn = 1.5707963267948966 * w;
      for (int f = 0; f < floors; ++f) {
        const std::uint32_t floor = made.scene.add_group(wing, "floor");
        for (int b = 0; b < bays; ++b) {
          const Mat4d frame =
              glm::rotate(glm::translate(Mat4d(1.0), centre), turn, Vec3d(0, 0, 1)) *
              placed({2.0 * b - 15.0, 20.0, 3.0 * f + 1.5});
          const Mat4d upright = glm::rotate(frame, 1.5707963267948966, Vec3d(1, 0, 0));
          made.add(wall, floor, upright);
          made.add(plant, floor, frame * placed({0.0, -1.5, -1.0}, b, 0.4));
        }
      }
    }
  }
  made.views = {{"near", {0, 15, 3}, {1, 20, 2.5}}, {"far", {-14, -15, 11}, {6, 12, 2}}};
  return made;
}

/// A room with a long table and 60 chairs, each a seat, a back and four legs.
inline KdtreeScene conference(std::size_t triangles) {
  KdtreeScene made;
  made.name = "conference";
  constexpr int chairs = 60;
  const std::size_t part = triangles / (chairs * 8);
  const std::uint32_t seat = made.mesh(tube(2 * part, 0.3f), "seat");
  const std::uint32_t back = made.mesh(sheet(2 * part, 0.0f), "back");
  const std::uint32_t leg = made.mesh(tube(part, 4.0f), "leg");
  const std::uint32_t plate = made.mesh(sheet(128, 0.0f), "plate");
  const std::uint32_t shell = made.scene.add_group(invalid_id, "shell");
  const Mat4d flat = glm::scale(Mat4d(1.0), Vec3d(1, 1, 0.001));
  made.add(plate, shell, placed({0, 0, 0}, 0.0, 20.0) * flat);
  made.add(plate, shell, placed({0, 0, 5}, 0.0, 20.0) * flat);
  made.add(plate, shell, placed({0, 0, 1}, 0.0, 3.0) * flat);
  const std::uint32_t rows = made.scene.add_group(invalid_id, "rows");
  for (int c = 0; c < chairs; ++c) {
    const std::uint32_t chair = made.scene.add_group(rows, "chair");
    const Mat4d frame = placed({1.2 * (c % 15) - 8.4, (c / 15 - 1.5) * 3.0, 0.0}, 0.3 * c);
    made.add(seat, chair, frame * placed({0, 0, 0.5}, 0.0, 0.35));
    made.add(back, chair,
             glm::rotate(frame * placed({0, 0.35, 0.9}, 0.0, 0.35), 1.57, Vec3d(1, 0, 0)));
    for (int l = 0; l < 4; ++l)
      made.add(leg, chair, frame * placed({l % 2 * 0.5 - 0.25, l / 2 * 0.5 - 0.25, 0}, 0, 0.12));
  }
  made.views = {{"near", {-8.4, -6.5, 1.2}, {-8.2, -4.5, 0.6}}, {"far", {-15, -12, 4}, {4, 3, 0}}};
  return made;
}

}  // namespace regraft::bench
