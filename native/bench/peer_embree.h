#pragma once

// Embree on the same meshes, in the same run; only where its library is installed.
#ifdef REGRAFT_WITH_EMBREE

#include <embree3/rtcore.h>

#include <algorithm>
#include <span>
#include <string>

#include "bench_rays.h"

namespace regraft::bench {

/// How Embree keeps its scene. Only `robust` comes near a claim of watertightness.
struct EmbreeOptions {
  RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
  bool robust = true;
  /// Made for change: two levels, a tree a geometry. Refitting needs it.
  bool dynamic = false;
  unsigned threads = 1;
};

/// A geometry that reads these arrays from now on. Embree reads 16 bytes of every vertex, so one
/// more has to follow the last.
inline RTCGeometry embree_triangles(RTCDevice device, RTCBuildQuality quality,
                                    std::span<const Vec3> vertices,
                                    std::span<const Triangle> triangles) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryBuildQuality(geometry, quality);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             vertices.data(), 0, sizeof(Vec3), vertices.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(),
                             0, sizeof(Triangle), triangles.size());
  rtcCommitGeometry(geometry);
  return geometry;
}

/// Told that the vertices of a geometry have moved.
inline void embree_moved(RTCGeometry geometry) {
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
}

/// An empty scene as the options say.
inline RTCScene embree_scene(RTCDevice device, const EmbreeOptions& options) {
  RTCScene scene = rtcNewScene(device);
  int flags = RTC_SCENE_FLAG_NONE;
  if (options.robust) flags |= RTC_SCENE_FLAG_ROBUST;
  if (options.dynamic) flags |= RTC_SCENE_FLAG_DYNAMIC;
  rtcSetSceneFlags(scene, RTCSceneFlags(flags));
  // Only a scene of low quality keeps a tree a geometry, built or refitted as that one asks.
  rtcSetSceneBuildQuality(scene, options.dynamic ? RTC_BUILD_QUALITY_LOW : options.quality);
  return scene;
}

/// An Embree scene over one mesh, with its own copy of the vertices.
class EmbreeScene {
 public:
  EmbreeScene(Triangles mesh, const EmbreeOptions& options)
      : mesh_(std::move(mesh)),
        device_(rtcNewDevice(("threads=" + std::to_string(options.threads)).c_str())),
        scene_(embree_scene(device_, options)) {
    mesh_.vertices.emplace_back(0.0f);
    geometry_ = embree_triangles(device_, options.quality,
                                 std::span(mesh_.vertices).first(mesh_.vertices.size() - 1),
                                 mesh_.triangles);
    rtcAttachGeometry(scene_, geometry_);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// Vertices moved: refits or rebuilds, as the options' quality says.
  void update() {
    embree_moved(geometry_);
    rtcCommitScene(scene_);
  }
  std::vector<Vec3>& vertices() { return mesh_.vertices; }
  RTCScene scene() const { return scene_; }

 private:
  Triangles mesh_;
  RTCDevice device_;
  RTCScene scene_;
  RTCGeometry geometry_;
};

template <int N>
struct EmbreePacket;
template <>
struct EmbreePacket<8> {
  using Rays = RTCRayHit8;
  static constexpr auto closest = &rtcIntersect8;
  static constexpr auto any = &rtcOccluded8;
  using Any = RTCRay8;
};
template <>
struct EmbreePacket<16> {
  using Rays = RTCRayHit16;
  static constexpr auto closest = &rtcIntersect16;
  static constexpr auto any = &rtcOccluded16;
  using Any = RTCRay16;
};

inline RTCIntersectContext embree_context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

/// Rays [begin, end) of the set, N at once; @return how many hit. `coherent`: whether Embree is
/// told that neighbours go the same way.
template <int N>
std::size_t embree_packets(RTCScene scene, const RaySet& set, bool coherent, std::size_t begin,
                           std::size_t end) {
  RTCIntersectContext context = embree_context(coherent);
  alignas(64) int valid[N];
  std::fill_n(valid, N, -1);
  std::size_t hits = 0;
  for (std::size_t first = begin; first < end; first += N) {
    alignas(64) typename EmbreePacket<N>::Rays rays;
    const auto load = [&](const std::vector<float>& from, float* to) {
      std::copy_n(from.data() + first, N, to);
    };
    load(set.origin[0], rays.ray.org_x), load(set.direction[0], rays.ray.dir_x);
    load(set.origin[1], rays.ray.org_y), load(set.direction[1], rays.ray.dir_y);
    load(set.origin[2], rays.ray.org_z), load(set.direction[2], rays.ray.dir_z);
    load(set.t_far, rays.ray.tfar);
    for (int i = 0; i < N; ++i) {
      rays.ray.tnear[i] = rays.ray.time[i] = 0.0f;
      rays.ray.mask[i] = ~0u;
      rays.ray.flags[i] = 0;
      rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    if (set.any)
      EmbreePacket<N>::any(valid, scene, &context,
                           reinterpret_cast<typename EmbreePacket<N>::Any*>(&rays.ray));
    else
      EmbreePacket<N>::closest(valid, scene, &context, &rays);
    for (int i = 0; i < N; ++i)
      hits += set.any ? rays.ray.tfar[i] < 0.0f : rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
  }
  return hits;
}

/// The same one ray at a time.
inline std::size_t embree_single(RTCScene scene, const RaySet& set, bool coherent,
                                 std::size_t begin, std::size_t end) {
  RTCIntersectContext context = embree_context(coherent);
  std::size_t hits = 0;
  for (std::size_t i = begin; i < end; ++i) {
    RTCRayHit ray;
    ray.ray = {set.origin[0][i],
               set.origin[1][i],
               set.origin[2][i],
               0.0f,
               set.direction[0][i],
               set.direction[1][i],
               set.direction[2][i],
               0.0f,
               set.t_far[i],
               ~0u,
               0,
               0};
    ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (set.any)
      rtcOccluded1(scene, &context, &ray.ray);
    else
      rtcIntersect1(scene, &context, &ray);
    hits += set.any ? ray.ray.tfar < 0.0f : ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  return hits;
}

}  // namespace regraft::bench

#endif
