#include "regraft/shade/corners.h"

#include <bit>
#include <cmath>

#include "regraft/simd/gather.h"

namespace regraft::shade {

namespace {

using simd::REGRAFT_SIMD_NAMESPACE::gather_points;
using simd::REGRAFT_SIMD_NAMESPACE::Points4;

void set(Vec3Lanes& lanes, std::uint32_t i, const Vec3& value) {
  lanes.x[i] = value.x;
  lanes.y[i] = value.y;
  lanes.z[i] = value.z;
}

void set_four(Vec3Lanes& lanes, std::uint32_t i, const Points4& value) {
  value.x[0].store(&lanes.x[i]);
  value.x[1].store(&lanes.y[i]);
  value.x[2].store(&lanes.z[i]);
}

/// Copies hits; lanes without one get the first that has.
void copy_hits(const trace::HitPacket& hits, LaneMask active, Corners& out) {
  const std::uint32_t first = std::uint32_t(std::countr_zero(active));
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const std::uint32_t from = has_lane(active, i) ? i : first;
    out.u[i] = hits.u[from];
    out.v[i] = hits.v[from];
    out.prim_id[i] = hits.prim_id[from];
    out.instance_id[i] = hits.instance_id[from];
  }
  std::uint32_t differing = 0;
  for (std::uint32_t i = 0; i < lane_count; ++i)
    differing |= out.instance_id[i] ^ out.instance_id[0];
  out.one_instance = differing == 0;
}

/// Unit normal of a triangle, for its flat corners; double, because edges of tiny or huge
/// triangles leave float's range when multiplied.
Vec3 flat_normal(const ShadedInstance& instance, const Triangle& t) {
  const Vec3d a(instance.vertices[t.x]);
  const Vec3d e1 = Vec3d(instance.vertices[t.y]) - a;
  const Vec3d e2 = Vec3d(instance.vertices[t.z]) - a;
  const Vec3d n(e1.y * e2.z - e1.z * e2.y, e1.z * e2.x - e1.x * e2.z, e1.x * e2.y - e1.y * e2.x);
  const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  return length > 0.0 ? Vec3(n / length) : Vec3(0.0f);
}

bool is_flat(const glm::uvec3& ids) {
  return (ids.x & ids.y & ids.z) == flat_corner;
}

/// One lane's normals, whatever its corners are.
void read_normals(const ShadedInstance& instance, std::uint32_t i, Corners& out) {
  const std::uint32_t prim = out.prim_id[i];
  const bool flat = instance.normal_ids == nullptr || is_flat(instance.normal_ids[prim]);
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t id = flat ? flat_corner : instance.normal_ids[prim][c];
    if (flat)
      set(out.normal[c], i, Vec3(0.0f));
    else if (id == flat_corner)
      set(out.normal[c], i, flat_normal(instance, instance.triangles[prim]));
    else
      set(out.normal[c], i, instance.normals[id]);
  }
}

void read_one(const ShadedInstance& instance, std::uint32_t i, Corners& out) {
  const Triangle& t = instance.triangles[out.prim_id[i]];
  for (int c = 0; c < 3; ++c) set(out.point[c], i, instance.vertices[t[c]]);
}

/// Corner c's entry of each of four lanes' rows in a table of three columns.
struct Rows4 {
  std::uint32_t id[3][4];
  Rows4(const glm::uvec3* table, const std::uint32_t* rows) {
    for (int k = 0; k < 4; ++k)
      for (int c = 0; c < 3; ++c) id[c][k] = table[rows[k]][c];
  }
  bool any_flat_corner() const {
    bool found = false;
    for (const auto& corner : id)
      for (const std::uint32_t entry : corner) found |= entry == flat_corner;
    return found;
  }
};

void read_four(const ShadedInstance& instance, std::uint32_t i, Corners& out) {
  const Rows4 rows(instance.triangles, &out.prim_id[i]);
  for (int c = 0; c < 3; ++c)
    set_four(out.point[c], i, gather_points(&instance.vertices->x, rows.id[c]));
}

void read_four_normals(const ShadedInstance& instance, std::uint32_t i, Corners& out) {
  const Rows4 rows(instance.normal_ids, &out.prim_id[i]);
  if (rows.any_flat_corner()) {
    for (std::uint32_t k = 0; k < 4; ++k) read_normals(instance, i + k, out);
    return;
  }
  for (int c = 0; c < 3; ++c)
    set_four(out.normal[c], i, gather_points(&instance.normals->x, rows.id[c]));
}

void read_run(const ShadedInstance& instance, std::uint32_t begin, std::uint32_t end,
              Corners& out) {
  std::uint32_t i = begin;
  for (; i + 4 <= end; i += 4) read_four(instance, i, out);
  for (; i < end; ++i) read_one(instance, i, out);
  out.smooth |= instance.normal_ids != nullptr;
}

void read_run_normals(const ShadedInstance& instance, std::uint32_t begin, std::uint32_t end,
                      Corners& out) {
  std::uint32_t i = begin;
  if (instance.normal_ids != nullptr)
    for (; i + 4 <= end; i += 4) read_four_normals(instance, i, out);
  for (; i < end; ++i) read_normals(instance, i, out);
}

}  // namespace

void read_corners(const trace::HitPacket& hits, LaneMask active, InstanceCache& instances,
                  Corners& out) {
  out.smooth = false;
  copy_hits(hits, active, out);
  for_each_run(out, instances,
               [&](const ShadedInstance& instance, std::uint32_t a, std::uint32_t b) {
                 read_run(instance, a, b, out);
               });
  if (!out.smooth) return;
  for_each_run(out, instances,
               [&](const ShadedInstance& instance, std::uint32_t a, std::uint32_t b) {
                 read_run_normals(instance, a, b, out);
               });
}

}  // namespace regraft::shade
