#pragma once

// Embree's builders over the same boxes as ours; only where its library is installed.
#include "peer_embree.h"

#ifdef REGRAFT_WITH_EMBREE

#include "regraft/core/aabb.h"
#include "regraft/core/aligned.h"

namespace regraft::bench {

/// `rtcBuildBVH` into binary nodes of the same size as ours.
class PeerBuild {
 public:
  PeerBuild(std::span<const Aabb> boxes, RTCBuildQuality quality, unsigned threads)
      : device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())),
        tree_(rtcNewBVH(device_)),
        all_(boxes.size()) {
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const Aabb& b = boxes[i];
      all_[i] = {b.lo.x, b.lo.y, b.lo.z, 0, b.hi.x, b.hi.y, b.hi.z, unsigned(i)};
    }
    arguments_ = rtcDefaultBuildArguments();
    arguments_.buildQuality = quality;
    arguments_.buildFlags = RTC_BUILD_FLAG_DYNAMIC;
    arguments_.maxBranchingFactor = 2;
    arguments_.maxLeafSize = 4;
    arguments_.minLeafSize = 1;
    arguments_.bvh = tree_;
    arguments_.createNode = create_node;
    arguments_.setNodeChildren = set_children;
    arguments_.setNodeBounds = set_bounds;
    arguments_.createLeaf = create_leaf;
  }
  ~PeerBuild() {
    rtcReleaseBVH(tree_);
    rtcReleaseDevice(device_);
  }
  PeerBuild(const PeerBuild&) = delete;
  PeerBuild& operator=(const PeerBuild&) = delete;

  /// The builder sorts its primitives: they are put back before each run.
  void prepare() {
    prims_ = all_;
    arguments_.primitives = prims_.data();
    arguments_.primitiveCount = arguments_.primitiveArrayCapacity = prims_.size();
  }
  void run() { rtcBuildBVH(&arguments_); }

 private:
  struct Node {
    RTCBounds bounds[2];
    Node* child[2];
  };
  static void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
    return new (rtcThreadLocalAlloc(allocator, sizeof(Node), 64)) Node;
  }
  static void set_children(void* node, void** children, unsigned number, void*) {
    for (unsigned i = 0; i < number; ++i)
      static_cast<Node*>(node)->child[i] = static_cast<Node*>(children[i]);
  }
  static void set_bounds(void* node, const RTCBounds** bounds, unsigned number, void*) {
    for (unsigned i = 0; i < number; ++i) static_cast<Node*>(node)->bounds[i] = *bounds[i];
  }
  static void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* prims,
                           size_t number, void*) {
    auto* ids = static_cast<unsigned*>(rtcThreadLocalAlloc(allocator, (number + 1) * 4, 16));
    ids[0] = unsigned(number);
    for (size_t i = 0; i < number; ++i) ids[i + 1] = prims[i].primID;
    return ids;
  }

  RTCDevice device_;
  RTCBVH tree_;
  AlignedVector<RTCBuildPrimitive> all_, prims_;
  RTCBuildArguments arguments_;
};

}  // namespace regraft::bench

#endif
