#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "regraft/bvh/radix_sort.h"
#include "regraft/scene/scene.h"
#include "regraft/trace/tracer.h"

namespace regraft::bindings {

/// Rows of three numbers in memory of any strides, not ours.
struct Rows {
  const std::byte* data = nullptr;
  std::ptrdiff_t row_bytes = 0;
  std::ptrdiff_t column_bytes = 0;
  bool is_double = false;

  Vec3d at(std::size_t row) const;
};

/// One number for all rays, or one a ray (then `data` is not null).
struct Limits {
  float constant = 0.0f;
  const std::byte* data = nullptr;
  std::ptrdiff_t row_bytes = 0;
};

/// N rays of the world frame; reads memory that somebody else keeps alive.
struct RayBatch {
  Rows origins;
  Rows directions;
  Limits t_near;
  Limits t_far;
  std::size_t count = 0;
  /// Which ray is traced when; empty: as they come.
  std::span<const bvh::KeyedId> order{};

  std::size_t packet_count() const;
  /// The ray that is traced at `position`.
  std::size_t ray(std::size_t position) const {
    return order.empty() ? position : order[position].id;
  }
  /// Those at positions 64 p to 64 p + 63. Those that are not finite, or go nowhere, are not
  /// active.
  void pack(std::size_t p, trace::RayPacket& rays) const;
};

/// Where hits go: N elements each, 3 N for normals.
struct HitArrays {
  float* t;
  std::uint32_t* instance_id;
  std::uint32_t* prim_id;
  float* u;
  float* v;
  float* normal;
};

/// Through the trees, or every ray against every triangle.
enum class Search { trees, brute_force };

/// Packets [begin, end) of `batch`, traced. Normals are unit vectors of the world frame, facing as
/// the transformed triangle is wound; zero where nothing is hit. Returns what it took.
trace::TraceCounters trace_closest(const RayBatch& batch, const trace::Tracer& tracer,
                                   const Scene& scene, Search search, std::size_t begin,
                                   std::size_t end, const HitArrays& hits);
trace::TraceCounters trace_any(const RayBatch& batch, const trace::Tracer& tracer,
                               std::size_t begin, std::size_t end, bool* hit);

/// True if the rays may gain from being traced together: enough of them, all into one octant.
/// Measured on three models: primary, shadow and parallel rays are then 1.2 to 2.6 times as fast,
/// others in one octant within 10 % of single rays; without agreement packets lose up to 20 %.
bool coherent(const trace::RayPacket& rays);

}  // namespace regraft::bindings
