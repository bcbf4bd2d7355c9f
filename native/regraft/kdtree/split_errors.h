#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "regraft/kdtree/seeded_builder.h"

namespace regraft::kdtree {

/// How far the planes that a scan chooses are from the best ones, over the nodes of a tree. f is
/// the cost of what is chosen, a plane or a leaf; errors are relative.
struct SplitErrors {
  std::uint64_t nodes = 0;
  double worst_excess = 0.0;  ///< f/f_exact − 1
  double mean_excess = 0.0;
  double worst_certificate = 0.0;  ///< what the scan itself proves of it
  double mean_certificate = 0.0;
  double mean_samples = 0.0;  ///< planes whose cost was computed
};

/// The errors of each of `scans` at the nodes of the tree that exact splits make of all primitives
/// of `view`: costs, chances and limits as in `config`. What counts are nodes at which the choice
/// is the scan's: neither leaves, nor where empty space is cut off, nor with so few entries that
/// they are sorted (ScanConfig::exact_below). One thread.
std::vector<SplitErrors> split_errors(const HierarchyView& view, const Config& config,
                                      std::span<const ScanConfig> scans);

}  // namespace regraft::kdtree
