#pragma once

#include <bit>
#include <cstdint>
#include <iosfwd>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "regraft/core/vec.h"
#include "regraft/trace/tracer.h"

namespace regraft::test {

inline constexpr float inf = std::numeric_limits<float>::infinity();
inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();

struct Ray {
  Vec3d origin{0.0};
  Vec3d direction{0.0, 0.0, -1.0};
  float t_near = 0.0f;
  float t_far = inf;
};
std::ostream& operator<<(std::ostream& out, const Ray& ray);

/// What a closest-hit query answers. Equal means equal in every bit.
struct Found {
  float t = inf;
  std::uint32_t instance = invalid_id;
  std::uint32_t prim = invalid_id;
  float u = 0.0f;
  float v = 0.0f;

  bool hit() const { return prim != invalid_id; }
  friend bool operator==(const Found& a, const Found& b) {
    const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
    return bits(a.t) == bits(b.t) && a.instance == b.instance && a.prim == b.prim &&
           bits(a.u) == bits(b.u) && bits(a.v) == bits(b.v);
  }
};
std::ostream& operator<<(std::ostream& out, const Found& found);

/// The two ways into the kernels.
enum class Entry { packet, single };
inline constexpr Entry entries[] = {Entry::packet, Entry::single};
const char* name(Entry entry);

/// Hands the rays over in packets: full ones and, every second time, ones whose lanes are partly
/// switched off and filled with rubbish.
/// @throws std::logic_error if a query touches a lane that is off, or counts another number of
/// rays.
std::vector<Found> closest_hits(const trace::Tracer& tracer, std::span<const Ray> rays,
                                Entry entry);
std::vector<bool> any_hits(const trace::Tracer& tracer, std::span<const Ray> rays, Entry entry);

}  // namespace regraft::test
