#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "regraft/bvh/binning.h"
#include "regraft/core/executor.h"

namespace regraft::bvh {

/// How many went left, and the boxes of both sides' centroids.
struct Partitioned {
  std::uint32_t count = 0;
  Box4 left, right;

  /// Centroids of the other side are moved out of the way, not jumped over: no processor could
  /// guess that branch.
  void add(Float4 centroid, bool is_left) {
    static constexpr float away[2] = {std::numeric_limits<float>::infinity(), 0.0f};
    const Float4 from_left(away[is_left]), from_right(away[!is_left]);
    left.extend(centroid + from_left, centroid - from_left);
    right.extend(centroid + from_right, centroid - from_right);
    count += is_left;
  }
  void add(const Partitioned& other) {
    count += other.count;
    left.extend(other.left);
    right.extend(other.right);
  }
};

/// Parts primitives in place, those that go left first; `spare` has room for as many. The order
/// within the sides stays.
///
/// Every primitive is written to where either side goes on, and one of the two moves on.
template <typename F>
Partitioned partition(std::span<PrimRef> refs, PrimRef* spare, const F& goes_left) {
  Partitioned parted;
  PrimRef* left = refs.data();
  PrimRef* right = spare;
  for (const PrimRef& ref : refs) {
    const bool is_left = goes_left(ref);
    parted.add(ref.centroid4(), is_left);
    const PrimRef copy = ref;
    *left = copy;
    *right = copy;
    left += is_left;
    right += !is_left;
  }
  std::copy(spare, right, left);
  return parted;
}

/// The same on all threads, to other memory. `left_counts` says how many of each `chunk` go left,
/// so that each is written to its place at once: the order does not depend on the threads.
template <typename F>
Partitioned partition_to(std::span<const PrimRef> refs, PrimRef* to,
                         const std::vector<std::uint32_t>& left_counts, std::size_t chunk,
                         const F& goes_left, Executor& executor) {
  std::vector<std::size_t> left_at(left_counts.size()), right_at(left_counts.size());
  std::size_t left = 0;
  for (std::size_t i = 0; i < left_counts.size(); ++i) {
    left_at[i] = left;
    right_at[i] = i * chunk - left;
    left += left_counts[i];
  }
  std::vector<Partitioned> parts(left_counts.size());
  executor.parallel_for(refs.size(), chunk, [&](std::size_t begin, std::size_t end) {
    Partitioned part;
    PrimRef* sides[2] = {to + left + right_at[begin / chunk], to + left_at[begin / chunk]};
    for (const PrimRef& ref : refs.subspan(begin, end - begin)) {
      const bool is_left = goes_left(ref);
      part.add(ref.centroid4(), is_left);
      *sides[is_left]++ = ref;
    }
    parts[begin / chunk] = part;
  });
  for (std::size_t i = 1; i < parts.size(); ++i) parts[0].add(parts[i]);
  return parts[0];
}

}  // namespace regraft::bvh
