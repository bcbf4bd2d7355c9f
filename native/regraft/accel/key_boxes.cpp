#include "regraft/accel/key_boxes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "regraft/bvh/key_frame_builder.h"

namespace regraft::accel {

namespace {

constexpr std::size_t grain = 16384;

bool finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// The box of three points, empty if one is not finite.
Aabb box_of(const std::vector<Vec3>& vertices, const Triangle& corners) {
  Aabb box;
  for (int i = 0; i < 3; ++i) {
    if (!finite(vertices[corners[i]])) return {};
    box.extend(vertices[corners[i]]);
  }
  return box;
}

Aabb box_of(const std::vector<Vec3>& vertices) {
  Aabb box;
  for (const Vec3& p : vertices)
    if (finite(p)) box.extend(p);
  return box;
}

/// The frame of `frames` that stands for key frame `j`; null if there are none.
template <typename T>
const T* frame_at(const std::vector<T>& frames, std::size_t j) {
  return frames.empty() ? nullptr : &frames[std::min(j, frames.size() - 1)];
}

/// One key frame of a scene.
class KeyFrame {
 public:
  KeyFrame(const Scene& scene, const InstanceSet& instances, std::size_t number)
      : scene_(scene), instances_(instances), number_(number) {}

  Aabb of_instance(std::uint32_t i) const {
    const std::vector<Vec3>* moved = frame_at(instances_.mesh(scene_, i).key_vertices, number_);
    return placed(i, moved != nullptr ? box_of(*moved) : instances_.tree(i).bounds());
  }

  Aabb of_triangle(const trace::FlatPrim& prim) const {
    const Mesh& mesh = instances_.mesh(scene_, prim.instance);
    const std::vector<Vec3>* moved = frame_at(mesh.key_vertices, number_);
    const std::vector<Vec3>& vertices = moved != nullptr ? *moved : mesh.vertices;
    return placed(prim.instance, box_of(vertices, mesh.triangles[prim.prim_id]));
  }

 private:
  Aabb placed(std::uint32_t i, const Aabb& local) const {
    if (local.empty()) return local;
    const Instance& instance = scene_.instances()[instances_.views()[i].instance_id];
    const Mat4d* moved = frame_at(instance.key_transforms, number_);
    Mat4d frame = instances_.frame(i);
    if (moved != nullptr) {
      frame = *moved;
      for (int k = 0; k < 3; ++k) frame[3][k] -= instances_.origin()[k];
    }
    return transform_bounds(frame, local, local.magnitude());
  }

  const Scene& scene_;
  const InstanceSet& instances_;
  std::size_t number_;
};

std::size_t key_frame_count(const Scene& scene, const InstanceSet& instances) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < instances.views().size(); ++i) {
    const Instance& instance = scene.instances()[instances.views()[i].instance_id];
    count = std::max(
        {count, instance.key_transforms.size(), instances.mesh(scene, i).key_vertices.size()});
  }
  return std::min(count, bvh::KeyFrameBuilder::max_frames);
}

}  // namespace

KeyBoxes key_boxes(const Mesh& mesh, Executor& executor) {
  KeyBoxes boxes(std::min(mesh.key_vertices.size(), bvh::KeyFrameBuilder::max_frames));
  for (std::size_t j = 0; j < boxes.size(); ++j) {
    boxes[j].resize(mesh.triangles.size());
    executor.parallel_for(boxes[j].size(), grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t)
        boxes[j][t] = box_of(mesh.key_vertices[j], mesh.triangles[t]);
    });
  }
  return boxes;
}

KeyBoxes key_boxes(const Scene& scene, const InstanceSet& instances,
                   std::span<const trace::FlatPrim> flat, Executor& executor) {
  KeyBoxes boxes(key_frame_count(scene, instances));
  for (std::size_t j = 0; j < boxes.size(); ++j) {
    const KeyFrame key(scene, instances, j);
    boxes[j].resize(flat.empty() ? instances.views().size() : flat.size());
    executor.parallel_for(boxes[j].size(), grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        boxes[j][i] = flat.empty() ? key.of_instance(std::uint32_t(i)) : key.of_triangle(flat[i]);
    });
  }
  return boxes;
}

void require_key_frames(const Scene& scene, const ChangeSet& changes) {
  const auto refuse = [](const std::string& who, const std::string& how) {
    throw std::invalid_argument(who +
                                " moves, and policy \"shot\" knows none of its key frames: "
                                "give them with " +
                                how +
                                " before the first update, or use "
                                "another policy");
  };
  for (const std::uint32_t id : changes.deformed_meshes)
    if (scene.meshes()[id].key_vertices.empty())
      refuse(label(scene.meshes()[id], id), "set_key_vertices");
  for (const std::uint32_t id : changes.moved_instances)
    if (scene.instances()[id].key_transforms.empty())
      refuse(label(scene.instances()[id], id), "set_key_transforms");
}

}  // namespace regraft::accel
