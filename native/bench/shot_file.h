#pragma once

// A shot that `regraft bench update --peers` has written down for the measuring program.

#include <stdexcept>

#include "bench_rays.h"
#include "binary_file.h"
#include "regraft/scene/scene.h"

namespace regraft::bench {

/// Plays the edits of a shot to a scene, frame by frame, as `cli/peer_shot_file.py` writes them.
class ShotFile {
 public:
  explicit ShotFile(const char* path) : file_(path), frames_(file_.one<std::uint32_t>()) {}

  std::uint32_t frames() const { return frames_; }

  /// Does to `scene` what leads to the next frame. @return that frame's number.
  std::uint32_t advance(Scene& scene) {
    for (;;) {
      const auto edit = file_.one<Edit>();
      if (edit == Edit::end_frame) break;
      apply(edit, scene);
    }
    const auto frame = file_.one<std::uint32_t>();
    camera_ = file_.one<Camera>();
    return frame;
  }

  /// Rays of the frame's camera through the pixels of a square picture, in tiles.
  RaySet primary_rays(int size) const {
    return tiled_rays(size, camera_.eye, [&](double x, double y) {
      return camera_.corner + x / size * camera_.right + y / size * camera_.up;
    });
  }

 private:
  enum class Edit : std::uint32_t {
    end_frame,
    add_mesh,
    set_vertices,
    set_mesh,
    remove_mesh,
    add_instance,
    set_transform,
    set_visible,
    remove_instance
  };
  /// A perspective: the picture lies from `corner`, seen from the eye, along `right` and `up`.
  struct Camera {
    Vec3d eye, corner, right, up;
  };

  Triangles mesh() {
    Triangles mesh;
    const auto vertices = file_.one<std::uint32_t>(), triangles = file_.one<std::uint32_t>();
    mesh.vertices = file_.many<Vec3>(vertices);
    mesh.triangles = file_.many<Triangle>(triangles);
    return mesh;
  }

  void add_instance(std::uint32_t mesh, Scene& scene) {
    Instance instance;
    instance.mesh = mesh;
    instance.object_to_world = file_.one<Mat4d>();
    scene.add_instance(instance);
  }

  void apply(Edit edit, Scene& scene) {
    if (edit == Edit::add_mesh) {
      const Triangles added = mesh();
      scene.add_mesh({added.vertices, added.triangles, {}, {}}, "mesh");
      return;
    }
    const auto id = file_.one<std::uint32_t>();
    switch (edit) {
      case Edit::set_vertices:
        return scene.set_vertices(id, file_.many<Vec3>(file_.one<std::uint32_t>()));
      case Edit::set_mesh: {
        const Triangles next = mesh();
        return scene.set_mesh(id, {next.vertices, next.triangles, {}, {}});
      }
      case Edit::remove_mesh:
        return scene.remove_mesh(id);
      case Edit::add_instance:
        return add_instance(id, scene);
      case Edit::set_transform:
        return scene.set_transform(id, file_.one<Mat4d>());
      case Edit::set_visible:
        return scene.set_visible(id, file_.one<std::uint32_t>() != 0);
      case Edit::remove_instance:
        return scene.remove_instance(id);
      default:
        throw std::runtime_error("the shot's file holds an edit that is not known");
    }
  }

  BinaryFile file_;
  std::uint32_t frames_;
  Camera camera_{};
};

}  // namespace regraft::bench
