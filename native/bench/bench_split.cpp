#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "regraft/kdtree/sah_scan.h"

namespace {

using namespace regraft;
using kdtree::OriginMetric;
using kdtree::SplitEntry;

// Accuracy and time of p_N.

struct Boxes {
  Aabb origins, box;
};

/// Boxes in rooms of any proportion: of any size, or with edges below a tenth of the room's.
std::vector<Boxes> random_boxes(bool small) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit;
  std::vector<Boxes> result(2000);
  for (Boxes& b : result) {
    b.origins.lo = b.box.lo = b.box.hi = Vec3(0);
    for (int k = 0; k < 3; ++k) {
      b.origins.hi[k] = std::exp2(3.0f * unit(random));
      const float edge = (small ? 0.1f : 1.0f) * unit(random);
      b.box.lo[k] = b.origins.hi[k] * (1.0f - edge) * unit(random);
      b.box.hi[k] = std::min(b.box.lo[k] + b.origins.hi[k] * edge, b.origins.hi[k]);
    }
  }
  return result;
}

void origin_metric(benchmark::State& state, OriginMetric metric, bool small) {
  const std::vector<Boxes> boxes = random_boxes(small);
  double square = 0.0;
  double largest = 0.0;
  for (const Boxes& b : boxes) {
    const double exact = visit_probability(OriginMetric::exact, b.origins, b.box);
    const double error = visit_probability(metric, b.origins, b.box) / exact - 1.0;
    square += error * error;
    largest = std::max(largest, std::fabs(error));
  }
  for (auto _ : state)
    for (const Boxes& b : boxes)
      benchmark::DoNotOptimize(visit_probability(metric, b.origins, b.box));
  state.SetItemsProcessed(state.iterations() * std::int64_t(boxes.size()));
  state.counters["error_rms"] = std::sqrt(square / double(boxes.size()));
  state.counters["error_max"] = largest;
}

// A plane's chances, as a search asks for them: one voxel, one axis, many planes.

void child_probability(benchmark::State& state, OriginMetric metric) {
  const Aabb room{Vec3(0), Vec3(10, 6, 3)};
  const kdtree::ChildProbability probability({Vec3(1, 1, 0), Vec3(7, 4, 2)}, metric, room);
  double position = 1.0;
  for (auto _ : state) {
    position = position > 6.9 ? 1.0 : position + 0.01;
    const auto pair = probability.at(0, position);
    benchmark::DoNotOptimize(pair.left + pair.right);
  }
}

// The search for a plane.

constexpr const char* distributions[] = {"uniform", "gaussian", "exponential",
                                         "grid",    "one huge", "teapot in stadium"};

Vec3 centre(std::mt19937& random, std::int64_t kind) {
  std::uniform_real_distribution<float> unit;
  std::normal_distribution<float> normal(0.5f, 0.12f);
  std::exponential_distribution<float> exponential(8.0f);
  Vec3 p;
  for (int k = 0; k < 3; ++k) {
    p[k] = kind == 1 ? normal(random) : kind == 2 ? exponential(random) : unit(random);
    if (kind == 3) p[k] = (std::floor(64.0f * p[k]) + 0.5f) / 64.0f;
    if (kind == 5) p[k] = 0.37f + 1e-4f * p[k];
    p[k] = std::clamp(p[k], 0.0f, 1.0f);
  }
  return p;
}

/// Boxes in the unit cube, distributed by `kind`.
std::vector<SplitEntry> entries(std::int64_t kind, std::int64_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit;
  const float size = kind == 5 ? 1e-6f : 0.5f / std::cbrt(float(count));
  std::vector<SplitEntry> result;
  for (std::int64_t i = 0; i < count; ++i) {
    const Vec3 half =
        kind == 3 ? Vec3(0.5f / 64.0f) : size * Vec3(unit(random), unit(random), unit(random));
    const Vec3 p = centre(random, kind);
    const bool huge = i == 0 && kind >= 4;
    result.push_back(huge ? SplitEntry{{Vec3(0), Vec3(1)}} : SplitEntry{{p - half, p + half}});
  }
  return result;
}

/// Arguments: distribution, entries. `search(entries, probability)` finds a split.
template <class Search>
void split(benchmark::State& state, Search search) {
  const std::vector<SplitEntry> list = entries(state.range(0), state.range(1));
  const kdtree::ChildProbability probability({Vec3(0), Vec3(1)});
  kdtree::Split found;
  for (auto _ : state) found = search.find(list, probability);
  const double exact = kdtree::SahSweep({.empty_cut = 2.0}).find(list, probability).cost;
  state.SetItemsProcessed(state.iterations() * std::int64_t(list.size()));
  state.SetLabel(distributions[state.range(0)]);
  state.counters["excess"] = found.cost / exact - 1.0;
  state.counters["certificate"] = found.certificate();
  state.counters["samples"] = double(found.samples);
}

kdtree::SahScan scan(double epsilon, int samples = 15) {
  return kdtree::SahScan({.empty_cut = 2.0},
                         {.epsilon = epsilon, .samples = samples, .exact_below = 0});
}

void all_kinds(benchmark::internal::Benchmark* bench) {
  bench->ArgsProduct({{0, 1, 2, 3, 4, 5}, {5000}})->Unit(benchmark::kMicrosecond);
}
void growing(benchmark::internal::Benchmark* bench) {
  bench->ArgsProduct({{0, 1}, {16, 64, 500, 3000, 20000, 180000}})->Unit(benchmark::kMicrosecond);
}

const int registered = [] {
  constexpr double never = std::numeric_limits<double>::infinity();
  const std::pair<const char*, OriginMetric> metrics[] = {{"sah", OriginMetric::sah},
                                                          {"regions6", OriginMetric::regions6},
                                                          {"regions26", OriginMetric::regions26},
                                                          {"faces", OriginMetric::faces},
                                                          {"exact", OriginMetric::exact}};
  const auto add = [](const std::string& name, const auto& run) {
    return benchmark::RegisterBenchmark(name.c_str(), run);
  };
  for (const auto& [name, metric] : metrics) {
    for (const bool small : {false, true})
      add(std::string("p_N/") + name + (small ? "/small" : "/any"),
          [metric, small](benchmark::State& state) { origin_metric(state, metric, small); });
    add(std::string("plane/") + name,
        [metric](benchmark::State& state) { child_probability(state, metric); });
  }
  const auto sweep = [](benchmark::State& state) {
    split(state, kdtree::SahSweep({.empty_cut = 2.0}));
  };
  all_kinds(add("split/sweep", sweep));
  growing(add("split/sweep", sweep));
  for (const double epsilon : {never, 0.3, 0.1, 0.03, 0.01, 0.0}) {
    const auto run = [epsilon](benchmark::State& state) { split(state, scan(epsilon)); };
    const std::string name = "split/scan/epsilon:" + std::to_string(epsilon);
    all_kinds(add(name, run));
    growing(add(name, run));
  }
  for (const int samples : {1, 3, 7, 15, 31, 63})
    all_kinds(add("split/scan/samples:" + std::to_string(samples),
                  [=](benchmark::State& state) { split(state, scan(never, samples)); }));
  return 0;
}();

}  // namespace
