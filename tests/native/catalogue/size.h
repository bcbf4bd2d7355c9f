#pragma once

#include <cstdint>

namespace regraft::test {

/// Where a case asks for a great many, as many as are still cheap: sanitizers make a tree some
/// twenty times slower, and what they look for does not depend on the number.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr std::uint32_t very_many = 10'000;
#else
inline constexpr std::uint32_t very_many = 100'000;
#endif

}  // namespace regraft::test
