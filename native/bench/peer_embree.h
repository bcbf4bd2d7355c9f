#pragma once

// Embree on the same meshes, in the same run; only where its library is installed.
#ifdef REGRAFT_WITH_EMBREE

#include <embree3/rtcore.h>

#include "bench_scenes.h"

namespace regraft::bench {

/// A robust Embree scene over one mesh, with its own copy of the vertices.
class EmbreeScene {
 public:
  EmbreeScene(Triangles mesh, RTCBuildQuality quality, unsigned threads)
      : mesh_(std::move(mesh)),
        device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())),
        scene_(rtcNewScene(device_)),
        geometry_(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE)) {
    rtcSetSceneFlags(scene_, RTCSceneFlags(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC));
    rtcSetSceneBuildQuality(scene_, quality);
    rtcSetGeometryBuildQuality(geometry_, quality);
    mesh_.vertices.emplace_back(0.0f);  // Embree reads 16 bytes of the last vertex.
    rtcSetSharedGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh_.vertices.data(), 0, sizeof(Vec3), mesh_.vertices.size() - 1);
    rtcSetSharedGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh_.triangles.data(), 0, sizeof(Triangle), mesh_.triangles.size());
    rtcCommitGeometry(geometry_);
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

  /// Vertices moved: refits or rebuilds, as `quality` says.
  void update(RTCBuildQuality quality) {
    rtcSetGeometryBuildQuality(geometry_, quality);
    rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry_);
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

}  // namespace regraft::bench

#endif
