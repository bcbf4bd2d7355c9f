#pragma once

#include <deque>
#include <span>
#include <string>
#include <vector>

#include "trace/compare.h"
#include "trace/scene_oracle.h"

namespace regraft::test {

/// One way to keep a scene's trees.
struct Setup {
  accel::Policy policy;
  accel::Layout layout;
  accel::Structure structure = accel::Structure::bvh;
  friend bool operator==(const Setup&, const Setup&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Setup& setup);
};

/// The ways that differ in trees just built: what is added here is tested everywhere.
std::span<const Setup> setups();
/// Every policy in every layout, and the k-d tree: for what moves.
std::span<const Setup> policies();

/// A scene and all accelerators that may keep it: each setup with each width of nodes, on pools of
/// 1, 2 and 5 threads, and one that changes its setup at every update. They live through the same
/// changes and must then answer alike.
class Bed {
 public:
  Bed();
  /// One accelerator for each of `kinds`, with nodes of either width by turns.
  explicit Bed(std::span<const Setup> kinds);

  Scene scene;

  std::uint32_t add(const Geometry& g, const Mat4d& m = Mat4d(1.0)) {
    return test::add(scene, g, m);
  }
  void deform(std::uint32_t mesh, const Geometry& g) { scene.set_vertices(mesh, g.vertices); }

  /// Tells all accelerators of rays that were traced: of many, and all damage is worth mending.
  void note_rays(std::uint64_t rays);
  /// Brings all accelerators up to date.
  /// @return the first invariant of a tree that is broken, or "".
  std::string update();

  /// Compares what every accelerator answers, in every bit, with brute force over a scene built
  /// anew.
  /// @return the first difference in words, or "".
  std::string differences(std::span<const Ray> rays) const;
  /// Judges the hits of a scene built anew by exact arithmetic.
  /// @return the first complaint, or "".
  std::string complaints(std::span<const Ray> rays, double ulps = 16.0) const;
  /// Both, for `nasty_rays` and for intervals that end exactly at their hits.
  std::string verdict(std::uint64_t seed, std::size_t count) const;
  /// An update, then the verdict: the first problem of either, or "".
  std::string problems(std::uint64_t seed = 1, std::size_t count = 192);

  std::vector<Found> hits(std::span<const Ray> rays) const { return hits_anew(scene, rays); }

  /// What the accelerators of a setup said at the last update.
  const accel::UpdateStatistics& statistics(const Setup& setup) const;
  /// Whether a warning of it holds these words.
  bool warns(const Setup& setup, const std::string& words) const;

 private:
  struct Slot {
    Setup setup;
    int width;
    unsigned threads;
    bool fickle;
    accel::Accelerator accelerator;
    accel::UpdateStatistics statistics;
  };

  void add_slot(const Setup& setup, int width, bool fickle);
  void make_fickle(Slot& slot) const;

  std::deque<Slot> slots_;
  std::uint64_t updates_ = 0;
};

}  // namespace regraft::test
