#include "regraft/simd/dispatch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "regraft/trace/kernels.h"

namespace regraft::simd {
namespace {

constexpr Isa all[] = {Isa::scalar, Isa::sse, Isa::avx2, Isa::avx512};

TEST(Dispatch, ScalarIsAlwaysThereAndTheListRises) {
  const std::vector<Isa> isas = available_isas();
  ASSERT_FALSE(isas.empty());
  EXPECT_EQ(isas.front(), Isa::scalar);
  EXPECT_TRUE(std::is_sorted(isas.begin(), isas.end()));
  EXPECT_EQ(std::adjacent_find(isas.begin(), isas.end()), isas.end());
  EXPECT_EQ(best_isa(), isas.back());
}

TEST(Dispatch, NamesAreReadBack) {
  for (const Isa isa : all) EXPECT_EQ(parse_isa(name(isa)), isa);
  EXPECT_EQ(name(Isa::avx2), "avx2");
  EXPECT_EQ(parse_isa("AVX2"), std::nullopt);
  EXPECT_EQ(parse_isa(""), std::nullopt);
}

TEST(Dispatch, KernelsExistForWhatIsThereAndAreRefusedByNameOtherwise) {
  const std::vector<Isa> isas = available_isas();
  for (const Isa isa : all) {
    if (std::find(isas.begin(), isas.end(), isa) != isas.end()) {
      const int width = trace::kernels(isa).width;
      EXPECT_TRUE(width == 4 || width == 8) << name(isa);
      continue;
    }
    try {
      trace::kernels(isa);
      FAIL() << name(isa) << " was not refused";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name(isa)), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace regraft::simd
