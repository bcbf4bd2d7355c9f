#include "regraft/bvh/calibrate.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/box4.h"
#include "regraft/bvh/morton_builder.h"

namespace regraft::bvh {

namespace {

constexpr std::size_t runs = 9;
constexpr std::size_t groups = 1024;

/// Seconds a call takes, the median of nine.
template <typename F>
double seconds(const F& call) {
  std::array<double, runs> times{};
  for (double& time : times) {
    const auto begin = std::chrono::steady_clock::now();
    call();
    time = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  std::nth_element(times.begin(), times.begin() + runs / 2, times.end());
  return times[runs / 2];
}

double seconds_each(const std::function<std::size_t()>& probe) {
  std::size_t count = 1;
  const double all = seconds([&] { count = std::max<std::size_t>(1, probe()); });
  return all / double(count);
}

/// Random numbers in [0, 1), the same on every machine.
std::vector<float> random_numbers(std::size_t count) {
  std::mt19937 engine(1);
  std::vector<float> numbers(count);
  for (float& x : numbers) x = float(engine() >> 8) * 0x1p-24f;
  return numbers;
}

/// What the compiler cannot leave out.
volatile std::uint32_t observed = 0;

/// Slab tests of one ray against four boxes at a time (numerics rule N2).
std::size_t run_box_tests(const std::vector<float>& numbers) {
  const Float4 origin(0.5f), inverse(1.5f), far_factor(1.00000024f);
  std::uint32_t hits = 0;
  for (std::size_t g = 0; g < groups; ++g) {
    const float* planes = &numbers[24 * g];
    Float4 t_near(0.0f), t_far(10.0f);
    for (int k = 0; k < 3; ++k) {
      t_near = max((Float4::load(planes + 8 * k) - origin) * inverse, t_near);
      t_far = min((Float4::load(planes + 8 * k + 4) - origin) * inverse * far_factor, t_far);
    }
    hits += t_near <= t_far;
  }
  observed = hits;
  return 4 * groups;
}

/// Shear, edge functions and distance of Woop, Benthin, Wald (JCGT 2013), four triangles at a time.
std::size_t run_triangle_tests(const std::vector<float>& numbers) {
  const Float4 shear_x(0.3f), shear_y(0.7f), origin(0.5f), zero(0.0f);
  std::uint32_t hits = 0;
  for (std::size_t g = 0; g < groups; ++g) {
    const float* corner = &numbers[36 * g];
    Float4 x[3], y[3], z[3];
    for (int i = 0; i < 3; ++i, corner += 12) {
      z[i] = Float4::load(corner + 8) - origin;
      x[i] = Float4::load(corner) - origin - shear_x * z[i];
      y[i] = Float4::load(corner + 4) - origin - shear_y * z[i];
    }
    const Float4 u = x[2] * y[1] - y[2] * x[1];
    const Float4 v = x[0] * y[2] - y[0] * x[2];
    const Float4 w = x[1] * y[0] - y[1] * x[0];
    const Float4 det = u + v + w;
    const Float4 t = (u * z[0] + v * z[1] + w * z[2]) / det;
    hits += ((u >= zero) & (v >= zero) & (w >= zero)) + (t <= origin);
  }
  observed = hits;
  return 4 * groups;
}

/// Seconds that `build` takes for each `unit(m)`, fitted through the origin.
template <typename Build, typename Unit>
double seconds_of_build(const Build& build, const Unit& unit) {
  double product = 0.0, square = 0.0;
  for (std::uint32_t m = 1u << 10; m <= 1u << 16; m *= 2) {
    const std::vector<float> numbers = random_numbers(3 * std::size_t(m));
    std::vector<Aabb> boxes(m);
    std::vector<std::uint32_t> ids(m);
    std::iota(ids.begin(), ids.end(), 0u);
    for (std::uint32_t i = 0; i < m; ++i) {
      boxes[i].extend(Vec3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]));
      boxes[i].extend(boxes[i].lo + Vec3(0.01f));
    }
    const double x = unit(double(m));
    product += x * seconds([&] { build(boxes, ids); });
    square += x * x;
  }
  return product / square;
}

}  // namespace

Probes test_probes() {
  return {[numbers = random_numbers(24 * groups)] { return run_box_tests(numbers); },
          [numbers = random_numbers(36 * groups)] { return run_triangle_tests(numbers); },
          {}};
}

MachineConstants calibrate(const Probes& probes, Executor& executor) {
  MachineConstants constants;
  const double box = seconds_each(probes.box_tests);
  constants.leaf = seconds_each(probes.triangle_tests) / box;
  using Boxes = std::vector<Aabb>;
  using Ids = std::vector<std::uint32_t>;
  const auto by_area = [&](const Boxes& boxes, const Ids& ids) {
    BinnedSahBuilder::build(boxes, ids, {}, executor);
  };
  const auto by_curve = [&](const Boxes& boxes, const Ids& ids) {
    MortonBuilder::build(boxes, ids, {}, executor);
  };
  constants.rebuild = seconds_of_build(by_area, [](double m) { return m * std::log2(m); }) / box;
  constants.morton = seconds_of_build(by_curve, [](double m) { return m; }) / box;
  if (probes.pairs) constants.refine = seconds_each(probes.pairs) / box;
  return constants;
}

}  // namespace regraft::bvh
