#pragma once

#include <cstdint>
#include <vector>

#include "regraft/core/aabb.h"

namespace regraft {

/// A node of a scene's hierarchy, or one of its primitives. Small, copied freely. `object`, `node`
/// and any `kind` but 0 mean what the view that made the entry says.
struct HierarchyEntry {
  /// Kind of a primitive: its object is what it belongs to, its node its number there.
  static constexpr std::uint32_t primitive_kind = 0;

  Aabb box;             ///< holds everything below
  double weight = 1.0;  ///< primitives below
  std::uint32_t object : 30 = 0;
  std::uint32_t kind : 2 = primitive_kind;
  std::uint32_t node = 0;

  bool primitive() const { return kind == primitive_kind; }
};

/// A scene as seeds of a tree see it: boxes over boxes down to primitives, opened one by one, and
/// never read where nobody looks. All coordinates are those of the tree.
///
/// Every function may be called from several threads at once, and answers alike each time.
class HierarchyView {
 public:
  virtual ~HierarchyView() = default;

  /// Appends what nothing else contains.
  virtual void top(std::vector<HierarchyEntry>& out) const = 0;

  /// Appends the children of an entry that is no primitive.
  virtual void open(const HierarchyEntry& entry, std::vector<HierarchyEntry>& out) const = 0;

  /// Box of what `voxel` holds of a primitive, with whatever a ray's rounding may take for it;
  /// empty if that is nothing.
  virtual Aabb clip(const HierarchyEntry& primitive, const Aabb& voxel) const = 0;

  /// Boxes of what both sides of a plane across `axis` keep of an entry, which is a primitive;
  /// within its box, and at least `clip` of that box's sides.
  virtual void clip_sides(const HierarchyEntry& primitive, int axis, float position,
                          Aabb (&sides)[2]) const {
    Aabb side[2] = {primitive.box, primitive.box};
    side[0].hi[axis] = side[1].lo[axis] = position;
    for (int s = 0; s < 2; ++s) sides[s] = clip(primitive, side[s]);
  }

  /// Largest number of children of any entry.
  virtual std::uint32_t fan_out() const = 0;
};

}  // namespace regraft
