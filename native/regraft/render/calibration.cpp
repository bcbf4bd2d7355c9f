#include "regraft/render/calibration.h"

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "regraft/accel/accelerator.h"
#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/pair_refinement.h"
#include "regraft/trace/kernels.h"
#include "regraft/trace/tracer.h"

namespace regraft::render {

namespace {

constexpr std::uint32_t side = 180;
constexpr std::uint32_t picture = 256;

/// Hills of 64,800 triangles over the unit square.
Scene hills() {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (std::uint32_t y = 0; y <= side; ++y)
    for (std::uint32_t x = 0; x <= side; ++x) {
      const double u = double(x) / side, v = double(y) / side;
      vertices.emplace_back(u, v,
                            0.05 * std::sin(9 * u) * std::cos(7 * v) + 0.01 * std::sin(61 * u));
      if (x == side || y == side) continue;
      const std::uint32_t at = y * (side + 1) + x;
      triangles.emplace_back(at, at + 1, at + side + 1);
      triangles.emplace_back(at + 1, at + side + 2, at + side + 1);
    }
  Scene scene;
  Instance instance;
  instance.mesh = scene.add_mesh({vertices, triangles, {}, {}}, "");
  scene.add_instance(instance);
  return scene;
}

/// 8×8 rays that look down on the hills aslant, the corner at pixel (x, y).
trace::RayPacket slanted(std::uint32_t x, std::uint32_t y) {
  trace::RayPacket rays;
  rays.count = 64;
  rays.active = ~std::uint64_t(0);
  for (std::uint32_t i = 0; i < 64; ++i) {
    const double target[3] = {(x + i % 8 + 0.5) / picture, (y + i / 8 + 0.5) / picture, 0.0};
    const double eye[3] = {0.5, -0.6, 0.8};
    for (int k = 0; k < 3; ++k) {
      rays.origin[k][i] = eye[k];
      rays.direction[k][i] = target[k] - eye[k];
    }
    rays.t_near[i] = 0.0f;
    rays.t_far[i] = std::numeric_limits<float>::infinity();
  }
  return rays;
}

/// Rays through a tree of hills; each call counts as the tests that C(root) expects of them.
class RayProbe {
 public:
  RayProbe(Executor& executor, simd::Isa isa) : executor_(executor), isa_(isa), scene_(hills()) {
    const int width = trace::kernels(isa).width;
    tests_ =
        accelerator_.update(scene_, scene_.take_changes(), {}, width, executor).culling_efficiency;
  }

  std::size_t operator()() {
    const trace::Tracer tracer(accelerator_.view(), isa_);
    executor_.parallel_for(picture / 8, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row)
        for (std::uint32_t x = 0; x < picture; x += 8) {
          trace::HitPacket hits;
          trace::TraceCounters counters;
          tracer.closest_hit(slanted(x, std::uint32_t(8 * row)), hits, counters);
        }
    });
    return std::size_t(tests_ * picture * picture);
  }

 private:
  Executor& executor_;
  simd::Isa isa_;
  Scene scene_;
  accel::Accelerator accelerator_;
  double tests_ = 0.0;
};

/// A tree so damaged that as many pairs are looked at as may be.
class PairProbe {
 public:
  explicit PairProbe(Executor& executor) {
    constexpr std::uint32_t count = 16384;
    std::mt19937 random(1);
    std::vector<Aabb> boxes(count);
    std::vector<std::uint32_t> ids(count);
    const auto scatter = [&] {
      for (std::uint32_t i = 0; i < count; ++i) {
        ids[i] = i;
        boxes[i] = {};
        boxes[i].extend(Vec3(float(random()), float(random()), float(random())) * 0x1p-32f);
        boxes[i].extend(boxes[i].lo + Vec3(0.01f));
      }
    };
    scatter();
    tree_.bvh = bvh::BinnedSahBuilder::build(boxes, ids, {}, executor);
    tree_.start_measuring(executor);
    scatter();
    bvh::refit(
        tree_, [&](std::uint32_t i) { return bvh::Box4(boxes[i]); }, executor);
  }

  std::size_t operator()() const {
    const bvh::RestructureConfig config;
    return bvh::refine_pairs(tree_, bvh::RestructuringBenefit(tree_, config, 1e12), config).size();
  }

 private:
  bvh::LivingBvh tree_;
};

}  // namespace

bvh::MachineConstants calibrate(Executor& executor, simd::Isa isa) {
  const auto rays = std::make_shared<RayProbe>(executor, isa);
  const auto pairs = std::make_shared<PairProbe>(executor);
  const auto tests = [rays] { return (*rays)(); };
  bvh::MachineConstants constants =
      bvh::calibrate({tests, tests, [pairs] { return (*pairs)(); }}, executor);
  // What a triangle costs beside a box is a matter of the two tests alone.
  constants.leaf = bvh::calibrate(bvh::test_probes(), executor).leaf;
  return constants;
}

}  // namespace regraft::render
