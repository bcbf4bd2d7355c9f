#pragma once

#include <cstdint>

namespace regraft::kdtree {
class KdTree;
}

namespace regraft::trace {

class LateTree;

/// Of so many packets one tells meshes what work it did in them.
inline constexpr std::uint32_t sample_every = 4;

/// What kernels read of a mesh: raw arrays owned by `Scene` and `Accelerator`.
struct MeshView {
  const float* vertices = nullptr;           ///< packed x, y, z; object space
  const std::uint32_t* triangles = nullptr;  ///< packed corner indices
  const void* nodes = nullptr;               ///< bvh::WideNode<width>[]; null: it has no tree
  std::uint8_t* entered = nullptr;           ///< as `TraceView::entered`
  /// Receives the nodes and triangles that sampled packets visited in this mesh. Written by all
  /// threads, read by the next update.
  std::uint64_t* work = nullptr;
  /// Not null: the tree may be behind; what is told of it here holds after `LateTree::arrive`.
  LateTree* late = nullptr;
  const std::uint32_t* prim_ids = nullptr;  ///< null: all triangles, in order
  std::uint32_t prim_count = 0;
  float magnitude = 0.0f;  ///< largest |coordinate| of the root's box
  double center[3]{};      ///< of the root's box
  double radius = 0.0;     ///< half its diagonal
  bool refitted = false;   ///< there may be triangles without area
};

/// False if all corners of a triangle lie on one line, exactly.
bool has_area(const MeshView& mesh, std::uint32_t prim);

/// A mesh placed in the world: p there is `world_to_object` · (p − `position`) in object space. The
/// difference is taken first, since it is exact for what is near the instance, however far both are
/// from the world's origin.
struct InstanceView {
  double world_to_object[9]{};  ///< row-major 3×3
  double position[3]{};         ///< of the object's origin, in the world
  MeshView mesh;
  float lo[3]{};  ///< box in the coordinates of the top tree
  float hi[3]{};
  std::uint32_t instance_id = 0;
  bool identity = false;
};

/// A primitive of the flat layout's one tree.
struct FlatPrim {
  std::uint32_t instance;  ///< index into `TraceView::instances`
  std::uint32_t prim_id;
};

/// Everything a query reads; constant while rays are traced, but for what they entered, and for
/// trees that they come near to.
///
/// A hit is defined by (ray, instance, triangle) alone: the ray is taken to object space in
/// double, rounded to float once, and tested there. Trees only leave out what cannot be hit, so
/// every layout, policy and instruction set gives the same bits.
struct TraceView {
  int width = 8;                    ///< slots of every wide node
  const void* top_nodes = nullptr;  ///< null: empty scene
  /// Per wide node: becomes 1 when a ray finds a slot in it. Written by all threads, read by the
  /// next update.
  std::uint8_t* entered = nullptr;
  const std::uint32_t* top_prims = nullptr;  ///< instance indices, or indices into `flat`
  const FlatPrim* flat = nullptr;            ///< null: two-level
  /// Not null: rays go through this tree, and the top tree is not looked at.
  const kdtree::KdTree* kdtree = nullptr;
  const InstanceView* instances = nullptr;
  std::uint32_t instance_count = 0;
  /// Subtracted from world positions before they are rounded to the top tree's floats (N5).
  double scene_origin[3]{};
  float magnitude = 0.0f;  ///< largest |coordinate| of the top tree's box
};

}  // namespace regraft::trace
