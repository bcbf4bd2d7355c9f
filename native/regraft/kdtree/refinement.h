#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "regraft/kdtree/seeded_builder.h"

namespace regraft::kdtree {

/// Cuts `box` to the voxel.
/// @return false if the voxel may do without it: they do not meet, or touch where the box goes on
/// beyond and so belongs to the neighbour.
bool cut(Aabb& box, const Aabb& voxel);

/// A node's list while it is refined. Triangles are clipped to the node's voxel when they come in.
class Refinement {
 public:
  Refinement(const HierarchyView& view, Refine order, const Pending& node);

  std::size_t size() const { return size_; }
  double weight() const;
  bool can_open() const { return next_ < inner_.size(); }

  void open_until(std::size_t count) {
    while (size_ < count && can_open()) open(pop());
  }

  /// Opens up to `count` entries, the heaviest first, that lie across the plane.
  /// @return false if there are none.
  bool open_straddlers(const Split& split, std::size_t count);

  /// The list as it is now. Valid until the next entry is opened.
  std::span<const HierarchyEntry> compacted();

 private:
  void note(std::size_t i);
  std::uint32_t pop();
  void open(std::uint32_t i);
  /// Orders the heap; the lower index wins a tie.
  auto before() const {
    return [this](std::uint32_t a, std::uint32_t b) {
      const double x = list_[a].weight * half_area(list_[a].box);
      const double y = list_[b].weight * half_area(list_[b].box);
      return x != y ? x < y : a > b;
    };
  }

  const HierarchyView& view_;
  const Refine order_;
  const Aabb voxel_;
  std::vector<HierarchyEntry> list_;
  std::vector<HierarchyEntry> children_;
  std::vector<std::uint8_t> open_;    ///< holes, until the list is compacted
  std::vector<std::uint32_t> inner_;  ///< not yet opened; a queue or a heap
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace regraft::kdtree
