#pragma once

// A scene that `regraft bench kdtree FILE` has written down for the measuring program.

#include "binary_file.h"
#include "kdtree_scenes.h"

namespace regraft::bench {

/// Groups (parents), meshes (counts, positions, corners), instances (mesh, group, matrix by
/// columns), the camera's place and what it looks at; as `bench_kdtree_file.py` writes them.
/// Views: near, three quarters of the way to that; far, the camera.
inline KdtreeScene read_scene(const char* name, const char* path) {
  KdtreeScene made;
  made.name = name;
  BinaryFile file(path);
  for (const std::uint32_t parent : file.many<std::uint32_t>(file.one<std::uint32_t>()))
    made.scene.add_group(parent, "group");
  const auto meshes = file.one<std::uint32_t>();
  for (std::uint32_t i = 0; i < meshes; ++i) {
    Triangles mesh;
    const auto vertices = file.one<std::uint32_t>(), triangles = file.one<std::uint32_t>();
    mesh.vertices = file.many<Vec3>(vertices);
    mesh.triangles = file.many<Triangle>(triangles);
    made.mesh(mesh, "mesh");
  }
  const auto instances = file.one<std::uint32_t>();
  for (std::uint32_t i = 0; i < instances; ++i) {
    const auto mesh = file.one<std::uint32_t>(), group = file.one<std::uint32_t>();
    made.add(mesh, group, file.one<Mat4d>());
  }
  const Vec3d eye = file.one<Vec3d>(), target = file.one<Vec3d>();
  made.views = {{"near", eye + 0.75 * (target - eye), target}, {"far", eye, target}};
  return made;
}

}  // namespace regraft::bench
