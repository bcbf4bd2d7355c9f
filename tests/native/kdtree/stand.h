#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "regraft/kdtree/kdtree.h"
#include "trace/compare.h"

namespace regraft::test {

/// A hierarchy that remembers what of it was opened.
class Watched final : public HierarchyView {
 public:
  explicit Watched(const HierarchyView& view) : view_(view) {}

  void top(std::vector<HierarchyEntry>& out) const override { view_.top(out); }
  void open(const HierarchyEntry& entry, std::vector<HierarchyEntry>& out) const override;
  Aabb clip(const HierarchyEntry& primitive, const Aabb& voxel) const override {
    return view_.clip(primitive, voxel);
  }
  std::uint32_t fan_out() const override { return view_.fan_out(); }

  using Opened = std::set<std::array<std::uint32_t, 3>>;
  Opened opened() const;
  /// From now on, opening the n-th entry throws.
  void fail_at(std::size_t n) { left_ = n; }

 private:
  const HierarchyView& view_;
  mutable std::mutex mutex_;
  mutable Opened opened_;
  mutable std::size_t left_ = std::size_t(-1);
};

/// A scene, its hierarchy as the accelerator makes it, and k-d trees of any configuration over it.
class Stand {
 public:
  Scene scene;

  void add(const Geometry& g, const Mat4d& m = Mat4d(1.0)) { test::add(scene, g, m); }
  /// To be called when the scene is complete.
  const HierarchyView& hierarchy();
  /// What kernels read, with `tree` in the place of the accelerator's.
  trace::TraceView view(const kdtree::KdTree& tree) const;
  /// The first answer through `tree` that is not brute force's, by any kernel; or "".
  std::string differences(const kdtree::KdTree& tree, std::span<const Ray> rays) const;

 private:
  accel::Accelerator accelerator_;
};

/// All eight.
std::vector<kdtree::Config> all_configurations();

/// The planes of all inner nodes by their path from the root ("", "0", "01" …), built ones only.
std::map<std::string, std::pair<int, float>> planes(const kdtree::KdTree& tree);

/// `count` rays through the ball of radius `reach` about 0, from outside and inside.
std::vector<Ray> crossing_rays(std::uint64_t seed, std::size_t count, double reach);

}  // namespace regraft::test
