#include "regraft/simd/dispatch.h"

#include <array>
#include <utility>

namespace regraft::simd {

namespace {
constexpr std::array<std::pair<Isa, std::string_view>, 4> names{
    {{Isa::scalar, "scalar"}, {Isa::sse, "sse"}, {Isa::avx2, "avx2"}, {Isa::avx512, "avx512"}}};
}

std::vector<Isa> available_isas() {
  std::vector<Isa> isas{Isa::scalar};
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("sse4.2")) isas.push_back(Isa::sse);
  if (__builtin_cpu_supports("avx2")) isas.push_back(Isa::avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
    isas.push_back(Isa::avx512);
#endif
  return isas;
}

Isa best_isa() {
  return available_isas().back();
}

std::string_view name(Isa isa) {
  return names[std::size_t(isa)].second;
}

std::optional<Isa> parse_isa(std::string_view text) {
  for (const auto& [isa, isa_name] : names)
    if (text == isa_name) return isa;
  return std::nullopt;
}

}  // namespace regraft::simd
