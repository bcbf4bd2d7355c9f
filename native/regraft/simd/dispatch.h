#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace regraft::simd {

/// Instruction sets for which traversal kernels exist, weakest first.
enum class Isa { scalar, sse, avx2, avx512 };

/// What this machine and operating system can run, weakest first; always holds `scalar`.
std::vector<Isa> available_isas();
/// The strongest of `available_isas`.
Isa best_isa();

std::string_view name(Isa isa);
std::optional<Isa> parse_isa(std::string_view text);

}  // namespace regraft::simd
