#pragma once

// Embree over a whole shot, kept in each of the ways that it offers.
#include "peer_embree.h"

#ifdef REGRAFT_WITH_EMBREE

#include <array>
#include <atomic>

#include "regraft/scene/scene.h"

namespace regraft::bench {

/// What Embree's scenes read, kept in line with a scene of ours: every mesh, and every visible
/// instance in world space. All contenders share it; keeping it is not part of their time.
class PeerGeometry {
 public:
  /// A visible instance: where its vertices and triangles lie in the arrays below.
  struct Piece {
    std::uint32_t instance, mesh;
    std::size_t vertex, vertices, triangle, triangles;
    bool moved = false;  ///< its matrix
    bool deformed = false;
  };

  void follow(const Scene& scene, const ChangeSet& changes) {
    is_new_ = changes.instance_set_changed || !changes.added_meshes.empty() ||
              !changes.removed_meshes.empty() || !changes.retopologised_meshes.empty();
    if (is_new_) return start(scene);
    const auto listed = [](const std::vector<std::uint32_t>& ids, std::size_t size) {
      std::vector<bool> is(size);
      for (const std::uint32_t id : ids) is[id] = true;
      return is;
    };
    deformed_ = listed(changes.deformed_meshes, scene.meshes().size());
    for (const std::uint32_t id : changes.deformed_meshes)
      std::ranges::copy(scene.meshes()[id].vertices, meshes_[id].vertices.begin());
    const auto moved = listed(changes.moved_instances, scene.instances().size());
    for (Piece& p : pieces_) {
      p.moved = moved[p.instance];
      p.deformed = deformed_[p.mesh];
      if (p.moved || p.deformed) place(scene, p);
    }
  }

  /// Whether scenes have to be made anew: other triangles, or others of them seen.
  bool is_new() const { return is_new_; }
  bool is_deformed(std::uint32_t mesh) const { return deformed_[mesh]; }
  bool is_still() const {
    return std::ranges::none_of(pieces_, [](const Piece& p) { return p.moved || p.deformed; });
  }
  std::span<const Piece> pieces() const { return pieces_; }
  /// By id; a vertex more than there are.
  std::span<const Triangles> meshes() const { return meshes_; }
  /// Of all pieces, with a vertex more than there are; corners count from the first of them.
  std::span<const Vec3> vertices() const {
    return std::span(vertices_).first(vertices_.size() - 1);
  }
  std::span<const Triangle> triangles() const { return triangles_; }

 private:
  void start(const Scene& scene) {
    meshes_.assign(scene.meshes().size(), {});
    deformed_.assign(scene.meshes().size(), false);
    for (std::size_t id = 0; id < meshes_.size(); ++id) {
      meshes_[id] = {scene.meshes()[id].vertices, scene.meshes()[id].triangles};
      meshes_[id].vertices.emplace_back(0.0f);
    }
    pieces_.clear();
    vertices_.clear();
    triangles_.clear();
    for (std::uint32_t id = 0; id < scene.instances().size(); ++id) {
      const Instance& instance = scene.instances()[id];
      if (!instance.alive || !instance.visible) continue;
      const Triangles& mesh = meshes_[instance.mesh];
      if (mesh.triangles.empty()) continue;
      const std::size_t count = mesh.vertices.size() - 1;
      pieces_.push_back(
          {id, instance.mesh, vertices_.size(), count, triangles_.size(), mesh.triangles.size()});
      for (const Triangle& t : mesh.triangles)
        triangles_.push_back(t + std::uint32_t(vertices_.size()));
      vertices_.resize(vertices_.size() + count);
    }
    vertices_.emplace_back(0.0f);
    for (const Piece& p : pieces_) place(scene, p);
  }

  void place(const Scene& scene, const Piece& p) {
    const Mat4d& matrix = scene.instances()[p.instance].object_to_world;
    const std::vector<Vec3>& from = meshes_[p.mesh].vertices;
    for (std::size_t i = 0; i < p.vertices; ++i)
      vertices_[p.vertex + i] = Vec3(matrix * glm::dvec4(Vec3d(from[i]), 1.0));
  }

  bool is_new_ = true;
  std::vector<Triangles> meshes_;
  std::vector<bool> deformed_;
  std::vector<Piece> pieces_;
  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
};

/// All in one geometry, a geometry an object in world space, or an instance an object.
enum class EmbreeWay { one_mesh, geometries, instances };

/// One of Embree's scenes, brought up to date every frame.
class EmbreeShot {
 public:
  EmbreeShot(EmbreeWay way, RTCBuildQuality quality, unsigned threads)
      : way_(way), device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())) {
    rtcSetDeviceMemoryMonitorFunction(device_, count_bytes, &bytes_);
    options_.quality = quality;
    options_.threads = threads;
    options_.dynamic = way != EmbreeWay::one_mesh || quality != RTC_BUILD_QUALITY_MEDIUM;
  }
  ~EmbreeShot() {
    clear();
    rtcReleaseDevice(device_);
  }
  EmbreeShot(const EmbreeShot&) = delete;
  EmbreeShot& operator=(const EmbreeShot&) = delete;

  void update(const PeerGeometry& from, const Scene& scene) {
    if (from.is_new()) return start(from, scene);
    if (from.is_still()) return;
    if (way_ == EmbreeWay::one_mesh) {
      embree_moved(geometries_[0]);
    } else if (way_ == EmbreeWay::geometries) {
      for (std::size_t i = 0; i < from.pieces().size(); ++i)
        if (from.pieces()[i].moved || from.pieces()[i].deformed) embree_moved(geometries_[i]);
    } else {
      follow_instances(from, scene);
    }
    rtcCommitScene(scene_);
  }

  RTCScene scene() const { return scene_; }
  /// Of Embree's own, without the vertices and triangles that it shares.
  std::size_t bytes() const { return std::size_t(bytes_.load()); }

 private:
  static bool count_bytes(void* sum, ssize_t bytes, bool) {
    *static_cast<std::atomic<std::ptrdiff_t>*>(sum) += bytes;
    return true;
  }

  void clear() {
    for (RTCGeometry geometry : geometries_) rtcReleaseGeometry(geometry);
    for (RTCGeometry geometry : mesh_geometries_)
      if (geometry) rtcReleaseGeometry(geometry);
    if (scene_) rtcReleaseScene(scene_);
    for (RTCScene scene : mesh_scenes_)
      if (scene) rtcReleaseScene(scene);
    geometries_.clear();
    mesh_geometries_.clear();
    mesh_scenes_.clear();
  }

  void start(const PeerGeometry& from, const Scene& scene) {
    clear();
    scene_ = embree_scene(device_, options_);
    mesh_scenes_.assign(from.meshes().size(), nullptr);
    mesh_geometries_.assign(from.meshes().size(), nullptr);
    if (way_ == EmbreeWay::one_mesh)
      geometries_ = {
          embree_triangles(device_, options_.quality, from.vertices(), from.triangles())};
    else
      for (const PeerGeometry::Piece& p : from.pieces())
        geometries_.push_back(way_ == EmbreeWay::geometries ? placed(from, p)
                                                            : instance(from, p, scene));
    for (RTCGeometry geometry : geometries_) rtcAttachGeometry(scene_, geometry);
    rtcCommitScene(scene_);
  }

  RTCGeometry placed(const PeerGeometry& from, const PeerGeometry::Piece& p) {
    const Triangles& mesh = from.meshes()[p.mesh];
    return embree_triangles(device_, options_.quality,
                            from.vertices().subspan(p.vertex, p.vertices), mesh.triangles);
  }

  RTCGeometry instance(const PeerGeometry& from, const PeerGeometry::Piece& p, const Scene& scene) {
    if (!mesh_scenes_[p.mesh]) {
      const Triangles& mesh = from.meshes()[p.mesh];
      mesh_scenes_[p.mesh] = embree_scene(device_, options_);
      mesh_geometries_[p.mesh] = embree_triangles(
          device_, options_.quality, std::span(mesh.vertices).first(p.vertices), mesh.triangles);
      rtcAttachGeometry(mesh_scenes_[p.mesh], mesh_geometries_[p.mesh]);
      rtcCommitScene(mesh_scenes_[p.mesh]);
    }
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, mesh_scenes_[p.mesh]);
    set_matrix(geometry, scene.instances()[p.instance].object_to_world);
    return geometry;
  }

  void follow_instances(const PeerGeometry& from, const Scene& scene) {
    for (std::uint32_t id = 0; id < mesh_scenes_.size(); ++id) {
      if (!mesh_scenes_[id] || !from.is_deformed(id)) continue;
      embree_moved(mesh_geometries_[id]);
      rtcCommitScene(mesh_scenes_[id]);
    }
    for (std::size_t i = 0; i < from.pieces().size(); ++i) {
      const PeerGeometry::Piece& p = from.pieces()[i];
      if (p.moved || p.deformed)
        set_matrix(geometries_[i], scene.instances()[p.instance].object_to_world);
    }
  }

  static void set_matrix(RTCGeometry geometry, const Mat4d& matrix) {
    const glm::mat4 single(matrix);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &single);
    rtcCommitGeometry(geometry);
  }

  EmbreeWay way_;
  EmbreeOptions options_;
  std::atomic<std::ptrdiff_t> bytes_{0};
  RTCDevice device_;
  RTCScene scene_ = nullptr;
  std::vector<RTCGeometry> geometries_;  ///< one, or one a piece
  std::vector<RTCScene> mesh_scenes_;    ///< by mesh id, of instances
  std::vector<RTCGeometry> mesh_geometries_;
};

}  // namespace regraft::bench

#endif
