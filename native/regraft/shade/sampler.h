#pragma once

#include <cstdint>

#include "regraft/shade/lanes.h"

namespace regraft::shade {

/// A point of the unit square for each lane.
struct PointLanes {
  FloatLanes u, v;
};

/// What a two-dimensional sample is for; lights count on from `first_light`.
enum class Dimension : std::uint32_t { pixel = 0, occlusion = 1, reach = 2, first_light = 8 };

/// Well-distributed points for the pixels of an 8×8 tile.
///
/// A pixel owns 2^k consecutive points (2^k ≥ `samples`) of one Owen-scrambled Sobol' (0,2)
/// sequence, and pixels follow each other along the Z curve: neighbours share out the square
/// between them, so what noise is left looks blue (Ahmed and Wonka, "Screen-Space Blue-Noise
/// Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", SIGGRAPH Asia
/// 2020). Their random base-4 digit shuffle is replaced by the base-2 shuffle and scrambling of
/// Burley, "Practical Hash-based Owen Scrambling", JCGT 2020, sections 3–5: one hash instead of
/// one a digit. A point depends on (pixel, sample, dimension, seed) alone.
class Sampler {
 public:
  Sampler(std::uint64_t seed, std::uint32_t samples);

  /// Points number `sample` < samples of the tile whose lower left pixel is (x0, y0).
  void points(std::uint32_t x0, std::uint32_t y0, std::uint32_t sample, std::uint32_t dimension,
              PointLanes& out) const;

  /// The same in one dimension.
  void numbers(std::uint32_t x0, std::uint32_t y0, std::uint32_t sample, std::uint32_t dimension,
               FloatLanes& out) const;

 private:
  std::uint32_t first_index(std::uint32_t x0, std::uint32_t y0, std::uint32_t sample) const;

  std::uint32_t seed_;
  std::uint32_t sample_bits_;
};

}  // namespace regraft::shade
