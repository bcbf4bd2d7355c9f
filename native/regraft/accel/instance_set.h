#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "regraft/accel/blas.h"
#include "regraft/scene/scene.h"

namespace regraft::accel {

class LateUpdate;

/// The instances rays can meet, ready to be traced: visible, placed by a usable matrix, with a
/// mesh that has something to hit. In ascending order of instance id.
///
/// World positions are kept relative to `origin()`, which is zero unless the scene lies far from
/// the world's origin (numerics rule N5). An instance whose matrix cannot be inverted safely is
/// baked: it gets world-space vertices and a tree of its own (N6).
class InstanceSet {
 public:
  struct Changes {
    bool set_changed = false;  ///< other instances than before, or another origin
    /// Instances whose box or matrix was recomputed, by their place in `views`.
    std::vector<std::size_t> moved;
    /// For each of those: whether all of it may have moved in the world, and not only those
    /// triangles that moved in its mesh.
    std::vector<std::uint8_t> as_a_whole;
    /// Where each of the instances before is now, `invalid_id` for those that are gone, or whose
    /// triangles the flat layout's tree holds and are others now. Empty if nothing can be said.
    std::vector<std::uint32_t> new_places;
    /// Work on trees of baked instances; `done` is the most that was done to any of them.
    TreeWork baked;
  };

  /// `blases` by mesh id, up to date. `changed_meshes[m]`: mesh m's geometry changed.
  Changes update(const Scene& scene, std::span<const Blas> blases, const ChangeSet& changes,
                 std::span<const std::uint8_t> changed_meshes, Layout layout, const Tending& how,
                 Executor& executor);

  /// Tells the set where the top tree ended up, so that it notices when the scene has wandered
  /// too far from `origin()` for float coordinates.
  void note_bounds(const Aabb& top);

  /// Shows the instances of meshes whose trees are behind what will be done about it; `late` by
  /// mesh id, null where nothing is.
  void link(const Scene& scene, std::span<const std::unique_ptr<LateUpdate>> late);

  std::span<const trace::InstanceView> views() const { return views_; }
  /// From the frame of `mesh(i)` to the world relative to `origin()`.
  const Mat4d& frame(std::size_t i) const { return frames_[i]; }
  const Vec3d& origin() const { return origin_; }
  /// The tree behind `views()[i]`.
  const Blas& tree(std::size_t i) const { return *trees_[i]; }
  /// The mesh that `views()[i]` refers to: the scene's, or the baked one.
  const Mesh& mesh(const Scene& scene, std::size_t i) const;

  const std::vector<std::string>& warnings() const { return warnings_; }
  std::size_t bytes() const;

 private:
  struct Baked {
    Mesh mesh;
    Blas blas;
    Vec3d center{0.0};
  };

  bool has_changed(const Scene& scene, std::span<const Blas> blases, const ChangeSet& changes,
                   std::span<const std::uint8_t> affected) const;
  bool collect(const Scene& scene, std::span<const Blas> blases,
               std::vector<std::uint32_t>& new_places);
  void tell_remade(const Scene& scene, std::span<const std::uint8_t> changed_meshes,
                   Changes& result) const;
  bool choose_origin(const Scene& scene, std::span<const Blas> blases, Executor& executor);
  bool place(const Scene& scene, std::size_t i);
  void bake(const Scene& scene, std::size_t i, bool topology_changed, Layout layout,
            const Tending& how, Executor& executor, TreeWork& work);

  std::vector<std::uint32_t> ids_;
  std::vector<trace::InstanceView> views_;
  std::vector<Mat4d> frames_;
  std::vector<const Blas*> trees_;
  const Blas* blases_ = nullptr;  ///< where the scene's trees were at the last update
  std::map<std::uint32_t, std::unique_ptr<Baked>> baked_;
  std::vector<std::string> warnings_;
  Vec3d origin_{0.0};
  Layout layout_ = Layout::two_level;
  bool wandered_ = false;
};

/// How a matrix can be used to place a mesh.
enum class Placement : std::uint8_t {
  direct,      ///< invert it
  bake,        ///< flat or badly conditioned: transform the vertices
  no_area,     ///< rank ≤ 1: nothing can be hit
  not_finite,  ///< NaN or infinite
  too_large    ///< takes the mesh beyond the range of floats
};
Placement classify(const Mat4d& object_to_world);
/// The same for a mesh with this box.
Placement classify(const Mat4d& object_to_world, const Aabb& box);

/// World box of an object box, rounded outward and widened by 2 ulp of its largest coordinate
/// (N4); `m` is double and relative to the scene's origin. Rays are rounded to float in object
/// space: the box also holds what lies off by as much as that costs where coordinates are as large
/// as `magnitude`, the mesh's largest.
Aabb transform_bounds(const Mat4d& m, const Aabb& box, float magnitude);

/// How far from a triangle of a placed mesh a ray's rounding may find it, axis by axis; `world`:
/// the mesh's world box. The same slack as in `transform_bounds`.
Vec3d placement_margin(const Mat4d& m, const Aabb& world, float magnitude);

}  // namespace regraft::accel
