#pragma once

#include <span>
#include <string>

#include "regraft/bvh/bvh.h"

namespace regraft::bvh {

/// Checks invariants I1–I4: one root, no node reached twice, the free list disjoint and its nodes
/// empty, depth as recorded and bounded, every box the exact union of what is below it
/// (`boxes[prim]` at the leaves), the primitives of `ids` each in exactly one leaf and no others.
/// @return the first violation in words, or "".
std::string validate(const Bvh& bvh, std::span<const Aabb> boxes,
                     std::span<const std::uint32_t> ids);

}  // namespace regraft::bvh
