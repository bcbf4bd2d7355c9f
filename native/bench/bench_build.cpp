#include <benchmark/benchmark.h>

#include <numeric>

#include "peer_embree.h"
#include "regraft/bvh/binned_sah_builder.h"
#include "regraft/bvh/morton_builder.h"
#include "regraft/bvh/sah.h"
#include "regraft/bvh/wide_bvh.h"

namespace {

using namespace regraft;

/// The boxes of one mesh, for builders that know nothing else.
struct Input {
  AlignedVector<Aabb> boxes;
  std::vector<std::uint32_t> ids;

  explicit Input(const benchmark::State& state) {
    const bench::Triangles mesh = bench::make(state.range(0), state.range(1), 0.0f);
    for (const Triangle& t : mesh.triangles) {
      Aabb box;
      for (int k = 0; k < 3; ++k) box.extend(mesh.vertices[t[k]]);
      boxes.push_back(box);
    }
    ids.resize(boxes.size());
    std::iota(ids.begin(), ids.end(), 0u);
  }
};

void count(benchmark::State& state, std::size_t triangles) {
  state.counters["triangles/s"] =
      benchmark::Counter(double(triangles), benchmark::Counter::kIsIterationInvariantRate);
}

template <typename Builder>
void build(benchmark::State& state) {
  const Input input(state);
  Executor executor(unsigned(state.range(2)));
  bvh::Bvh tree;
  for (auto _ : state) tree = Builder::build(input.boxes, input.ids, {}, executor);
  count(state, input.ids.size());
  state.counters["sah_cost"] = bvh::sah_cost(tree);
  state.counters["nodes/triangle"] = double(tree.node_count()) / double(input.ids.size());
}
void binned_sah(benchmark::State& state) {
  build<bvh::BinnedSahBuilder>(state);
}
void morton(benchmark::State& state) {
  build<bvh::MortonBuilder>(state);
}

void derive_wide(benchmark::State& state) {
  const Input input(state);
  Executor executor(unsigned(state.range(2)));
  const bvh::Bvh tree = bvh::MortonBuilder::build(input.boxes, input.ids, {}, executor);
  bvh::WideBvh wide;
  for (auto _ : state) wide = bvh::WideBvh::derive(tree, 8, executor);
  count(state, input.ids.size());
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"kind", "triangles", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int kind : {0, 1})
    for (const int threads : {1, 2}) b->Args({kind, 1000000, threads});
}
BENCHMARK(morton)->Apply(sizes);
BENCHMARK(binned_sah)->Apply(sizes);
BENCHMARK(derive_wide)->Apply(sizes);

#ifdef REGRAFT_WITH_EMBREE
/// Embree's builders over the same boxes, into binary nodes of the same size as ours.
struct PeerNode {
  RTCBounds bounds[2];
  PeerNode* child[2];
};
void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(PeerNode), 64)) PeerNode;
}
void set_children(void* node, void** children, unsigned number, void*) {
  for (unsigned i = 0; i < number; ++i)
    static_cast<PeerNode*>(node)->child[i] = static_cast<PeerNode*>(children[i]);
}
void set_bounds(void* node, const RTCBounds** bounds, unsigned number, void*) {
  for (unsigned i = 0; i < number; ++i) static_cast<PeerNode*>(node)->bounds[i] = *bounds[i];
}
void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* prims, size_t number,
                  void*) {
  auto* ids = static_cast<unsigned*>(rtcThreadLocalAlloc(allocator, (number + 1) * 4, 16));
  ids[0] = unsigned(number);
  for (size_t i = 0; i < number; ++i) ids[i + 1] = prims[i].primID;
  return ids;
}

void embree_build(benchmark::State& state, RTCBuildQuality quality) {
  const Input input(state);
  RTCDevice device = rtcNewDevice(("threads=" + std::to_string(state.range(2))).c_str());
  RTCBVH tree = rtcNewBVH(device);
  AlignedVector<RTCBuildPrimitive> all(input.boxes.size()), prims;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Aabb& b = input.boxes[i];
    all[i] = {b.lo.x, b.lo.y, b.lo.z, 0, b.hi.x, b.hi.y, b.hi.z, unsigned(i)};
  }
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.buildQuality = quality;
  arguments.buildFlags = RTC_BUILD_FLAG_DYNAMIC;
  arguments.maxBranchingFactor = 2;
  arguments.maxLeafSize = 4;
  arguments.minLeafSize = 1;
  arguments.bvh = tree;
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  arguments.createLeaf = create_leaf;
  for (auto _ : state) {
    state.PauseTiming();
    prims = all;  // The builder sorts them.
    state.ResumeTiming();
    arguments.primitives = prims.data();
    arguments.primitiveCount = arguments.primitiveArrayCapacity = prims.size();
    rtcBuildBVH(&arguments);
  }
  count(state, input.ids.size());
  rtcReleaseBVH(tree);
  rtcReleaseDevice(device);
}
void embree_build_morton(benchmark::State& state) {
  embree_build(state, RTC_BUILD_QUALITY_LOW);
}
void embree_build_sah(benchmark::State& state) {
  embree_build(state, RTC_BUILD_QUALITY_MEDIUM);
}
BENCHMARK(embree_build_morton)->Apply(sizes);
BENCHMARK(embree_build_sah)->Apply(sizes);
#endif

}  // namespace
