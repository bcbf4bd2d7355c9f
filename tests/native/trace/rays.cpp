#include "trace/rays.h"

#include <ostream>
#include <stdexcept>

namespace regraft::test {

namespace {

constexpr std::uint64_t full = ~std::uint64_t(0);
/// Lanes off at the start, in the middle and at the end.
constexpr std::uint64_t with_holes = 0x7FFBFFFF80F5FFFEu;

struct Batch {
  trace::RayPacket packet;
  std::size_t lane_of[trace::packet_capacity];  ///< lane of the i-th ray
  std::size_t count = 0;
};

Batch make_batch(std::span<const Ray> rays, std::uint64_t lanes) {
  Batch batch;
  trace::RayPacket& p = batch.packet;
  p.count = trace::packet_capacity;
  for (std::size_t lane = 0; lane < trace::packet_capacity; ++lane) {
    const bool on = (lanes >> lane & 1u) != 0 && batch.count < rays.size();
    const Ray rubbish{Vec3d(nan), Vec3d(nan), nan, nan};
    const Ray& ray = on ? rays[batch.count] : rubbish;
    for (int k = 0; k < 3; ++k) {
      p.origin[k][lane] = ray.origin[k];
      p.direction[k][lane] = ray.direction[k];
    }
    p.t_near[lane] = ray.t_near;
    p.t_far[lane] = ray.t_far;
    if (!on) continue;
    p.active |= std::uint64_t(1) << lane;
    batch.lane_of[batch.count++] = lane;
  }
  return batch;
}

template <typename Query>
void for_each_batch(std::span<const Ray> rays, const Query& query) {
  std::size_t done = 0;
  for (bool holes = false; done < rays.size(); holes = !holes) {
    const Batch batch = make_batch(rays.subspan(done), holes ? with_holes : full);
    trace::TraceCounters counters;
    query(batch, counters, done);
    if (counters.rays != batch.count) throw std::logic_error("rays were counted wrongly");
    done += batch.count;
  }
}

Found found_in(const trace::HitPacket& hits, std::size_t lane) {
  return {hits.t[lane], hits.instance_id[lane], hits.prim_id[lane], hits.u[lane], hits.v[lane]};
}

void check_untouched(const Batch& batch, const trace::HitPacket& hits, const Found& mark) {
  for (std::size_t lane = 0; lane < trace::packet_capacity; ++lane) {
    const bool on = (batch.packet.active >> lane & 1u) != 0;
    if (!on && !(found_in(hits, lane) == mark))
      throw std::logic_error("a lane that is off was written");
  }
}

}  // namespace

const char* name(Entry entry) {
  return entry == Entry::packet ? "packet" : "single";
}

std::ostream& operator<<(std::ostream& out, const Ray& ray) {
  const auto vec = [&](const Vec3d& v) { out << "(" << v.x << ", " << v.y << ", " << v.z << ")"; };
  out << std::hexfloat;
  vec(ray.origin);
  out << " + t ";
  vec(ray.direction);
  return out << ", t in [" << ray.t_near << ", " << ray.t_far << "]" << std::defaultfloat;
}

std::ostream& operator<<(std::ostream& out, const Found& found) {
  if (!found.hit()) return out << "miss (t " << found.t << ")";
  return out << "instance " << found.instance << " triangle " << found.prim << std::hexfloat
             << " at t " << found.t << ", u " << found.u << ", v " << found.v << std::defaultfloat;
}

std::vector<Found> closest_hits(const trace::Tracer& tracer, std::span<const Ray> rays,
                                Entry entry) {
  const Found mark{-1.0f, 7, 8, 0.25f, 0.5f};
  std::vector<Found> result(rays.size());
  for_each_batch(rays, [&](const Batch& batch, trace::TraceCounters& counters, std::size_t first) {
    trace::HitPacket hits;
    for (std::size_t i = 0; i < trace::packet_capacity; ++i) {
      hits.t[i] = mark.t, hits.u[i] = mark.u, hits.v[i] = mark.v;
      hits.instance_id[i] = mark.instance, hits.prim_id[i] = mark.prim;
    }
    if (entry == Entry::packet)
      tracer.closest_hit(batch.packet, hits, counters);
    else
      tracer.closest_hit_single(batch.packet, hits, counters);
    check_untouched(batch, hits, mark);
    for (std::size_t i = 0; i < batch.count; ++i)
      result[first + i] = found_in(hits, batch.lane_of[i]);
  });
  return result;
}

std::vector<bool> any_hits(const trace::Tracer& tracer, std::span<const Ray> rays, Entry entry) {
  std::vector<bool> result(rays.size());
  for_each_batch(rays, [&](const Batch& batch, trace::TraceCounters& counters, std::size_t first) {
    const std::uint64_t bits = entry == Entry::packet
                                   ? tracer.any_hit(batch.packet, counters)
                                   : tracer.any_hit_single(batch.packet, counters);
    if ((bits & ~batch.packet.active) != 0)
      throw std::logic_error("a lane that is off was reported as hit");
    for (std::size_t i = 0; i < batch.count; ++i)
      result[first + i] = (bits >> batch.lane_of[i] & 1u) != 0;
  });
  return result;
}

}  // namespace regraft::test
