#include "regraft/core/aligned.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace regraft::test {
namespace {

constexpr std::size_t megabyte = std::size_t(1) << 20;

bool on_boundary(const void* p, std::size_t boundary) {
  return reinterpret_cast<std::uintptr_t>(p) % boundary == 0;
}

TEST(Aligned, SmallMemoryLiesOnCacheLinesAndLargeOnLargePages) {
  for (const std::size_t bytes : {std::size_t(1), std::size_t(100), 4 * megabyte, 9 * megabyte}) {
    void* p = allocate_aligned(bytes);
    EXPECT_TRUE(on_boundary(p, bytes < 4 * megabyte ? 64 : 2 * megabyte));
    free_aligned(p, bytes);
  }
}

TEST(Aligned, ALargeBlockIsTakenAgainForWhatIsAboutAsLarge) {
  void* in_use = allocate_aligned(64 * megabyte);
  void* first = allocate_aligned(33 * megabyte);
  free_aligned(first, 33 * megabyte);
  void* second = allocate_aligned(34 * megabyte);
  EXPECT_EQ(second, first);
  free_aligned(second, 34 * megabyte);
  free_aligned(in_use, 64 * megabyte);
}

TEST(Aligned, BlocksThatAreInUseAreNeverShared) {
  std::vector<AlignedVector<std::uint32_t>> all;
  for (std::uint32_t round = 0; round < 100; ++round) {
    AlignedVector<std::uint32_t> block((1 + round % 5) * megabyte);
    block.front() = block.back() = round;
    all.push_back(std::move(block));
    if (round % 3 != 0) all.erase(all.begin() + round % std::ptrdiff_t(all.size()));
    for (const AlignedVector<std::uint32_t>& kept : all) EXPECT_EQ(kept.front(), kept.back());
    while (all.size() > 4) all.erase(all.begin());
  }
}

}  // namespace
}  // namespace regraft::test
