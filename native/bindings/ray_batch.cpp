#include "ray_batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "world_normal.h"

namespace regraft::bindings {

namespace {

using trace::HitPacket;
using trace::packet_capacity;
using trace::RayPacket;

/// Fewer rays cost less one by one.
constexpr int worth_a_packet = 8;

template <typename T>
T value_at(const std::byte* data) {
  T value;
  std::memcpy(&value, data, sizeof(T));
  return value;
}

template <typename T>
Vec3d row_at(const std::byte* data, std::ptrdiff_t step) {
  return {value_at<T>(data), value_at<T>(data + step), value_at<T>(data + 2 * step)};
}

template <typename T>
void load(const RayBatch& batch, const Rows& rows, std::size_t first, std::uint32_t count,
          double (&out)[3][packet_capacity]) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto row = static_cast<std::ptrdiff_t>(batch.ray(first + i));
    const Vec3d value = row_at<T>(rows.data + row * rows.row_bytes, rows.column_bytes);
    for (int k = 0; k < 3; ++k) out[k][i] = value[k];
  }
}

void load(const RayBatch& batch, const Rows& rows, std::size_t first, std::uint32_t count,
          double (&out)[3][packet_capacity]) {
  if (rows.is_double) {
    load<double>(batch, rows, first, count, out);
  } else {
    load<float>(batch, rows, first, count, out);
  }
}

void load(const RayBatch& batch, const Limits& limits, std::size_t first, std::uint32_t count,
          float (&out)[packet_capacity]) {
  if (limits.data == nullptr) {
    std::fill_n(out, count, limits.constant);
    return;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto row = static_cast<std::ptrdiff_t>(batch.ray(first + i));
    out[i] = value_at<float>(limits.data + row * limits.row_bytes);
  }
}

/// Bit i is set if ray i is finite and goes somewhere. Zero times a number is NaN unless that is
/// finite.
std::uint64_t usable_rays(const RayPacket& rays) {
  std::uint64_t usable = 0;
  for (std::uint32_t i = 0; i < rays.count; ++i) {
    double zero = 0.0;
    for (int k = 0; k < 3; ++k) zero += 0.0 * rays.origin[k][i] + 0.0 * rays.direction[k][i];
    const bool moves =
        rays.direction[0][i] != 0.0 || rays.direction[1][i] != 0.0 || rays.direction[2][i] != 0.0;
    const bool ok = zero == 0.0 && moves && rays.t_near[i] <= rays.t_far[i];
    usable |= static_cast<std::uint64_t>(ok) << i;
  }
  return usable;
}

void store(const HitPacket& hits, std::uint32_t i, const Scene& scene, const HitArrays& out,
           std::size_t ray) {
  const Vec3 normal = world_normal(scene, hits.instance_id[i], hits.prim_id[i]);
  out.t[ray] = hits.t[i];
  out.instance_id[ray] = hits.instance_id[i];
  out.prim_id[ray] = hits.prim_id[i];
  out.u[ray] = hits.u[i];
  out.v[ray] = hits.v[i];
  for (int k = 0; k < 3; ++k) out.normal[3 * ray + static_cast<std::size_t>(k)] = normal[k];
}

void store_miss(const HitArrays& out, std::size_t ray) {
  out.t[ray] = std::numeric_limits<float>::infinity();
  out.instance_id[ray] = out.prim_id[ray] = invalid_id;
  out.u[ray] = out.v[ray] = 0.0f;
  std::fill_n(out.normal + 3 * ray, 3, 0.0f);
}

}  // namespace

bool coherent(const RayPacket& rays) {
  if (std::popcount(rays.active) < worth_a_packet) return false;
  const int first = std::countr_zero(rays.active);
  for (std::uint64_t todo = rays.active; todo != 0; todo &= todo - 1) {
    const int i = std::countr_zero(todo);
    for (int k = 0; k < 3; ++k) {
      if (std::signbit(rays.direction[k][i]) != std::signbit(rays.direction[k][first]))
        return false;
    }
  }
  return true;
}

Vec3d Rows::at(std::size_t row) const {
  const std::byte* first = data + static_cast<std::ptrdiff_t>(row) * row_bytes;
  return is_double ? row_at<double>(first, column_bytes) : row_at<float>(first, column_bytes);
}

std::size_t RayBatch::packet_count() const {
  return (count + packet_capacity - 1) / packet_capacity;
}

void RayBatch::pack(std::size_t p, RayPacket& rays) const {
  const std::size_t first = p * packet_capacity;
  rays.count = static_cast<std::uint32_t>(std::min<std::size_t>(packet_capacity, count - first));
  load(*this, origins, first, rays.count, rays.origin);
  load(*this, directions, first, rays.count, rays.direction);
  load(*this, t_near, first, rays.count, rays.t_near);
  load(*this, t_far, first, rays.count, rays.t_far);
  rays.active = usable_rays(rays);
}

trace::TraceCounters trace_closest(const RayBatch& batch, const trace::Tracer& tracer,
                                   const Scene& scene, Search search, std::size_t begin,
                                   std::size_t end, const HitArrays& out) {
  RayPacket rays;
  HitPacket hits;
  trace::TraceCounters counters;
  for (std::size_t p = begin; p < end; ++p) {
    batch.pack(p, rays);
    if (search == Search::brute_force) {
      tracer.brute_force(rays, hits, counters);
    } else if (coherent(rays)) {
      tracer.closest_hit(rays, hits, counters);
    } else {
      tracer.closest_hit_single(rays, hits, counters);
    }
    for (std::uint32_t i = 0; i < rays.count; ++i) {
      const std::size_t ray = batch.ray(p * packet_capacity + i);
      if ((rays.active >> i & 1) != 0 && hits.instance_id[i] != invalid_id) {
        store(hits, i, scene, out, ray);
      } else {
        store_miss(out, ray);
      }
    }
  }
  return counters;
}

trace::TraceCounters trace_any(const RayBatch& batch, const trace::Tracer& tracer,
                               std::size_t begin, std::size_t end, bool* hit) {
  RayPacket rays;
  trace::TraceCounters counters;
  for (std::size_t p = begin; p < end; ++p) {
    batch.pack(p, rays);
    const std::uint64_t found =
        coherent(rays) ? tracer.any_hit(rays, counters) : tracer.any_hit_single(rays, counters);
    for (std::uint32_t i = 0; i < rays.count; ++i) {
      hit[batch.ray(p * packet_capacity + i)] = ((found & rays.active) >> i & 1) != 0;
    }
  }
  return counters;
}

}  // namespace regraft::bindings
