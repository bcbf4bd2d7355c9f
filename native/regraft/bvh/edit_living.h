#pragma once

#include <optional>

#include "regraft/bvh/edit.h"
#include "regraft/bvh/living_bvh.h"

namespace regraft::bvh {

/// As `edit` of a `Bvh`. A measured tree knows what is new in it as just put in order, and seen;
/// metrics are taken by the next refit.
/// @return the number of nodes that are new or hold something else, or none where `edit` returns
/// false.
std::optional<std::uint64_t> edit(LivingBvh& tree, const PrimitiveEdit& change,
                                  const std::function<Box4(std::uint32_t)>& bounds,
                                  const BinnedSahBuilder::Config& builder, Executor& executor,
                                  Reshaping& changes);

}  // namespace regraft::bvh
