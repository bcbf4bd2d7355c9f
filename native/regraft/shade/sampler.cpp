#include "regraft/shade/sampler.h"

#include <algorithm>
#include <bit>

namespace regraft::shade {

namespace {

/// The steps commute. In this order the compiler does not see a byte swap in them, an instruction
/// that has no SIMD version everywhere.
std::uint32_t reverse_bits(std::uint32_t x) {
  x = x >> 16 | x << 16;
  x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
  x = (x >> 8 & 0x00FF00FFu) | (x & 0x00FF00FFu) << 8;
  x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
  return (x >> 4 & 0x0F0F0F0Fu) | (x & 0x0F0F0F0Fu) << 4;
}

/// A nested uniform (Owen) scramble of a number whose bits are reversed: a bit depends only on
/// those below it. Constants of Vegdahl, "Building a Better LK Hash", 2021.
std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

/// Second dimension of the Sobol' sequence, as a fraction of 2^32, from the index with its bits
/// reversed (which is the first dimension). Its generator matrix is Pascal's triangle mod 2, a
/// Kronecker power of ((1 1) (0 1)), hence five butterflies instead of a matrix product.
std::uint32_t sobol_second(std::uint32_t first) {
  std::uint32_t x = first;
  x ^= x << 1 & 0xAAAAAAAAu;
  x ^= x << 2 & 0xCCCCCCCCu;
  x ^= x << 4 & 0xF0F0F0F0u;
  x ^= x << 8 & 0xFF00FF00u;
  return x ^ x << 16;
}

std::uint32_t mix(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x21f0aaadu;
  x ^= x >> 15;
  x *= 0xd35a2d97u;
  return x ^ x >> 15;
}

/// Bits of x at even places, so that two of them interleave to a place on the Z curve.
std::uint32_t spread(std::uint32_t x) {
  x &= 0xFFFFu;
  x = (x | x << 8) & 0x00FF00FFu;
  x = (x | x << 4) & 0x0F0F0F0Fu;
  x = (x | x << 2) & 0x33333333u;
  return (x | x << 1) & 0x55555555u;
}

/// Signed, because only that conversion exists for every SIMD instruction set.
float unit_float(std::uint32_t x) {
  return float(std::int32_t(x >> 8)) * 0x1p-24f;
}

/// Place of each lane's pixel on the Z curve through a tile.
constexpr Lanes<std::uint32_t> z_order = [] {
  Lanes<std::uint32_t> order{};
  for (std::uint32_t i = 0; i < lane_count; ++i)
    order[i] =
        (i & 1u) | (i & 2u) << 1 | (i & 4u) << 2 | (i & 8u) >> 2 | (i & 16u) >> 1 | (i & 32u);
  return order;
}();

}  // namespace

Sampler::Sampler(std::uint64_t seed, std::uint32_t samples)
    : seed_(mix(std::uint32_t(seed) ^ mix(std::uint32_t(seed >> 32) + 0x9E3779B9u))),
      sample_bits_(std::min(31u, std::uint32_t(std::bit_width(samples - 1)))) {}

std::uint32_t Sampler::first_index(std::uint32_t x0, std::uint32_t y0, std::uint32_t sample) const {
  return (spread(x0) | spread(y0) << 1) << sample_bits_ | sample;
}

void Sampler::points(std::uint32_t x0, std::uint32_t y0, std::uint32_t sample,
                     std::uint32_t dimension, PointLanes& out) const {
  const std::uint32_t shuffle = mix(seed_ + 3 * dimension);
  const std::uint32_t scramble_u = mix(seed_ + 3 * dimension + 1);
  const std::uint32_t scramble_v = mix(seed_ + 3 * dimension + 2);
  const std::uint32_t tile = first_index(x0, y0, sample);
  const std::uint32_t bits = sample_bits_;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const std::uint32_t index = tile + (z_order[i] << bits);
    const std::uint32_t first = scramble_reversed(reverse_bits(index), shuffle);
    const std::uint32_t u = scramble_reversed(reverse_bits(first), scramble_u);
    const std::uint32_t v = scramble_reversed(reverse_bits(sobol_second(first)), scramble_v);
    out.u[i] = unit_float(reverse_bits(u));
    out.v[i] = unit_float(reverse_bits(v));
  }
}

void Sampler::numbers(std::uint32_t x0, std::uint32_t y0, std::uint32_t sample,
                      std::uint32_t dimension, FloatLanes& out) const {
  const std::uint32_t shuffle = mix(seed_ + 3 * dimension);
  const std::uint32_t tile = first_index(x0, y0, sample);
  const std::uint32_t bits = sample_bits_;
  for (std::uint32_t i = 0; i < lane_count; ++i)
    out[i] = unit_float(scramble_reversed(reverse_bits(tile + (z_order[i] << bits)), shuffle));
}

}  // namespace regraft::shade
