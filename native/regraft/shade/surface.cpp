#include "regraft/shade/surface.h"

#include <bit>
#include <cmath>

namespace regraft::shade {

namespace {

/// Offsets secondary rays by this share of the coordinates they were computed from: the triangle
/// test's rounding error is 2^-20.4 of them (numerics rule N7; Wächter and Binder, "A Fast and
/// Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, 2019, offset by 2^-15 since
/// they reconstruct the position in world space and single precision).
constexpr float offset_ratio = 0x1p-18f;
/// The same for the instance's place in the world, which is added in double.
constexpr float translation_ratio = 0x1p-46f;

/// Triangles as found in their meshes, object space.
struct Corners {
  Vec3Lanes p0, p1, p2;
  Vec3Lanes n0, n1, n2;  ///< unit, or zero at flat corners of wholly flat triangles
  FloatLanes u, v;
  std::uint32_t prim_id[lane_count];
  std::uint32_t instance_id[lane_count];
  bool smooth = false;
  bool one_instance = true;
};

/// Object-space results.
struct LocalSurface {
  Vec3Lanes point;
  Vec3Lanes geometric;  ///< not a unit vector
  Vec3Lanes normal;     ///< neither; zero where the triangle is flat
  FloatLanes size;      ///< of the coordinates `point` was computed from
};

void set(Vec3Lanes& lanes, std::uint32_t i, const Vec3& value) {
  lanes.x[i] = value.x;
  lanes.y[i] = value.y;
  lanes.z[i] = value.z;
}

/// Unit normal of a triangle for its flat corners; double, because edges of tiny or huge
/// triangles leave float's range when multiplied.
Vec3 flat_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3d e1 = Vec3d(b) - Vec3d(a);
  const Vec3d e2 = Vec3d(c) - Vec3d(a);
  const Vec3d n(e1.y * e2.z - e1.z * e2.y, e1.z * e2.x - e1.x * e2.z, e1.x * e2.y - e1.y * e2.x);
  const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  return length > 0.0 ? Vec3(n / length) : Vec3(0.0f);
}

void set_corner_normals(const ShadedInstance& instance, std::uint32_t prim, std::uint32_t i,
                        Corners& out) {
  const glm::uvec3 ids =
      instance.normal_ids != nullptr ? instance.normal_ids[prim] : glm::uvec3(flat_corner);
  const bool flat = (ids.x & ids.y & ids.z) == flat_corner;
  Vec3 corner[3] = {Vec3(0.0f), Vec3(0.0f), Vec3(0.0f)};
  if (!flat) {
    out.smooth = true;
    const Triangle& t = instance.triangles[prim];
    const Vec3* p = instance.vertices;
    for (int c = 0; c < 3; ++c)
      corner[c] =
          ids[c] != flat_corner ? instance.normals[ids[c]] : flat_normal(p[t.x], p[t.y], p[t.z]);
  }
  set(out.n0, i, corner[0]);
  set(out.n1, i, corner[1]);
  set(out.n2, i, corner[2]);
}

/// Reads the triangles. Lanes that are not active repeat the first active one, so that later
/// loops meet nothing undefined and need no mask.
void gather(const trace::HitPacket& hits, LaneMask active, SurfaceNeeds needs,
            InstanceCache& instances, Corners& out, const Material** material) {
  const std::uint32_t first = std::uint32_t(std::countr_zero(active));
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const std::uint32_t from = has_lane(active, i) ? i : first;
    const std::uint32_t prim = hits.prim_id[from];
    const ShadedInstance& instance = instances.find(hits.instance_id[from]);
    const Triangle& t = instance.triangles[prim];
    set(out.p0, i, instance.vertices[t.x]);
    set(out.p1, i, instance.vertices[t.y]);
    set(out.p2, i, instance.vertices[t.z]);
    out.u[i] = hits.u[from];
    out.v[i] = hits.v[from];
    out.instance_id[i] = instance.id;
    out.one_instance &= instance.id == out.instance_id[0];
    set_corner_normals(instance, prim, i, out);
    if (needs.materials) material[i] = &instances.material(instance, prim);
  }
}

float largest(float x, float y, float z) {
  return max_of(max_of(std::fabs(x), std::fabs(y)), std::fabs(z));
}

/// Hit points and triangle normals. Edges are scaled to size one first: their product then
/// neither overflows nor vanishes.
void interpolate(const Corners& c, LocalSurface& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float ax = c.p1.x[i] - c.p0.x[i], ay = c.p1.y[i] - c.p0.y[i], az = c.p1.z[i] - c.p0.z[i];
    const float bx = c.p2.x[i] - c.p0.x[i], by = c.p2.y[i] - c.p0.y[i], bz = c.p2.z[i] - c.p0.z[i];
    out.point.x[i] = c.p0.x[i] + (c.u[i] * ax + c.v[i] * bx);
    out.point.y[i] = c.p0.y[i] + (c.u[i] * ay + c.v[i] * by);
    out.point.z[i] = c.p0.z[i] + (c.u[i] * az + c.v[i] * bz);
    const float size_a = largest(ax, ay, az), size_b = largest(bx, by, bz);
    out.size[i] = largest(c.p0.x[i], c.p0.y[i], c.p0.z[i]) + (size_a + size_b);
    const float sa = 1.0f / max_of(size_a, 1e-37f), sb = 1.0f / max_of(size_b, 1e-37f);
    out.geometric.x[i] = (ay * sa) * (bz * sb) - (az * sa) * (by * sb);
    out.geometric.y[i] = (az * sa) * (bx * sb) - (ax * sa) * (bz * sb);
    out.geometric.z[i] = (ax * sa) * (by * sb) - (ay * sa) * (bx * sb);
  }
}

void interpolate_normals(const Corners& c, LocalSurface& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float u = c.u[i], v = c.v[i], w = 1.0f - u - v;
    out.normal.x[i] = w * c.n0.x[i] + (u * c.n1.x[i] + v * c.n2.x[i]);
    out.normal.y[i] = w * c.n0.y[i] + (u * c.n1.y[i] + v * c.n2.y[i]);
    out.normal.z[i] = w * c.n0.z[i] + (u * c.n1.z[i] + v * c.n2.z[i]);
  }
}

/// Moves `point` by `weight` times its depth below the plane through corner p with normal n.
inline void lift(const Vec3Lanes& p, const Vec3Lanes& n, float side, float weight, std::uint32_t i,
                 const float (&at)[3], float (&moved)[3]) {
  const float below =
      side * ((at[0] - p.x[i]) * n.x[i] + (at[1] - p.y[i]) * n.y[i] + (at[2] - p.z[i]) * n.z[i]);
  const float rise = side * weight * (below < 0.0f ? below : 0.0f);
  moved[0] -= rise * n.x[i];
  moved[1] -= rise * n.y[i];
  moved[2] -= rise * n.z[i];
}

/// Lifts hit points from the triangle to the curved surface its normals stand for, so that its
/// own facets do not shadow it: Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II,
/// 2021, section 4.3. `side` is −1 where the back of the triangle is seen.
void lift_to_curved(const Corners& c, const FloatLanes& side, LocalSurface& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float at[3] = {out.point.x[i], out.point.y[i], out.point.z[i]};
    float moved[3] = {at[0], at[1], at[2]};
    const float u = c.u[i], v = c.v[i];
    lift(c.p0, c.n0, side[i], 1.0f - u - v, i, at, moved);
    lift(c.p1, c.n1, side[i], u, i, at, moved);
    lift(c.p2, c.n2, side[i], v, i, at, moved);
    out.point.x[i] = moved[0];
    out.point.y[i] = moved[1];
    out.point.z[i] = moved[2];
  }
}

/// Runs `body(instance, first, last)` over the lanes: at once where they share an instance, so
/// that its matrix stays in registers, one by one otherwise.
template <typename Body>
void with_instances(const Corners& corners, InstanceCache& instances, const Body& body) {
  if (corners.one_instance) {
    const ShadedInstance instance = instances.find(corners.instance_id[0]);
    body(instance, 0u, lane_count);
    return;
  }
  for (std::uint32_t i = 0; i < lane_count; ++i)
    body(instances.find(corners.instance_id[i]), i, i + 1);
}

void transform_normals(const ShadedInstance& instance, const Vec3Lanes& from, std::uint32_t begin,
                       std::uint32_t end, Vec3Lanes& to) {
  const auto& m = instance.cofactor;
  for (std::uint32_t i = begin; i < end; ++i) {
    const float x = from.x[i], y = from.y[i], z = from.z[i];
    to.x[i] = m[0][0] * x + (m[0][1] * y + m[0][2] * z);
    to.y[i] = m[1][0] * x + (m[1][1] * y + m[1][2] * z);
    to.z[i] = m[2][0] * x + (m[2][1] * y + m[2][2] * z);
  }
}

void set_views(const trace::RayPacket& rays, Vec3Lanes& view) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float x = float(rays.direction[0][i]);
    const float y = float(rays.direction[1][i]);
    const float z = float(rays.direction[2][i]);
    const float scale = -1.0f / std::sqrt(x * x + (y * y + z * z));
    view.x[i] = x * scale;
    view.y[i] = y * scale;
    view.z[i] = z * scale;
  }
}

/// Unit normals turned to the viewer; `side` is −1 where they had to be turned. A triangle
/// without area left counts as facing the viewer.
void face_viewer(const Vec3Lanes& view, Vec3Lanes& n, FloatLanes& side) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float length2 = n.x[i] * n.x[i] + n.y[i] * n.y[i] + n.z[i] * n.z[i];
    const float along = n.x[i] * view.x[i] + n.y[i] * view.y[i] + n.z[i] * view.z[i];
    const bool valid = length2 > 1e-30f;
    side[i] = along < 0.0f ? -1.0f : 1.0f;
    const float scale = side[i] / std::sqrt(valid ? length2 : 1.0f);
    n.x[i] = valid ? n.x[i] * scale : view.x[i];
    n.y[i] = valid ? n.y[i] * scale : view.y[i];
    n.z[i] = valid ? n.z[i] * scale : view.z[i];
  }
}

/// Unit shading normals on the viewer's side. Where interpolation turned one away from the
/// viewer (silhouettes of coarse meshes), it is bent back until it is seen edge-on.
void finish_normals(const SurfaceLanes& surface, const FloatLanes& side, Vec3Lanes& n) {
  const Vec3Lanes& g = surface.geometric;
  const Vec3Lanes& view = surface.view;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float length2 = n.x[i] * n.x[i] + n.y[i] * n.y[i] + n.z[i] * n.z[i];
    const bool valid = length2 > 1e-12f;
    const float scale = side[i] / std::sqrt(valid ? length2 : 1.0f);
    const float x = valid ? n.x[i] * scale : g.x[i];
    const float y = valid ? n.y[i] * scale : g.y[i];
    const float z = valid ? n.z[i] * scale : g.z[i];
    const float seen = x * view.x[i] + y * view.y[i] + z * view.z[i];
    const float bend = max_of(0.0f, 0.01f - seen);
    const float bx = x + bend * view.x[i], by = y + bend * view.y[i], bz = z + bend * view.z[i];
    const float unit = 1.0f / std::sqrt(max_of(bx * bx + by * by + bz * bz, 1e-12f));
    n.x[i] = bx * unit;
    n.y[i] = by * unit;
    n.z[i] = bz * unit;
  }
}

void place(const ShadedInstance& instance, const LocalSurface& local, const Vec3Lanes& geometric,
           std::uint32_t begin, std::uint32_t end, DoubleLanes (&position)[3]) {
  const auto& m = instance.rotation;
  const float constant = translation_ratio * instance.translation_size;
  const float ratio = offset_ratio * instance.stretch;
  for (std::uint32_t i = begin; i < end; ++i) {
    const double x = local.point.x[i], y = local.point.y[i], z = local.point.z[i];
    const float offset = ratio * local.size[i] + constant;
    position[0][i] = (m[0][0] * x + (m[0][1] * y + m[0][2] * z)) +
                     (instance.translation[0] + double(offset * geometric.x[i]));
    position[1][i] = (m[1][0] * x + (m[1][1] * y + m[1][2] * z)) +
                     (instance.translation[1] + double(offset * geometric.y[i]));
    position[2][i] = (m[2][0] * x + (m[2][1] * y + m[2][2] * z)) +
                     (instance.translation[2] + double(offset * geometric.z[i]));
  }
}

}  // namespace

void find_surfaces(const trace::RayPacket& rays, const trace::HitPacket& hits, LaneMask active,
                   SurfaceNeeds needs, InstanceCache& instances, SurfaceLanes& out) {
  Corners corners;
  LocalSurface local;
  FloatLanes side;
  out.active = active;
  gather(hits, active, needs, instances, corners, out.material);
  interpolate(corners, local);
  if (corners.smooth) interpolate_normals(corners, local);
  set_views(rays, out.view);
  with_instances(corners, instances,
                 [&](const ShadedInstance& m, std::uint32_t a, std::uint32_t b) {
                   transform_normals(m, local.geometric, a, b, out.geometric);
                   if (corners.smooth) transform_normals(m, local.normal, a, b, out.normal);
                 });
  face_viewer(out.view, out.geometric, side);
  if (corners.smooth)
    finish_normals(out, side, out.normal);
  else
    out.normal = out.geometric;
  if (!needs.positions) return;
  if (corners.smooth) lift_to_curved(corners, side, local);
  with_instances(corners, instances,
                 [&](const ShadedInstance& m, std::uint32_t a, std::uint32_t b) {
                   place(m, local, out.geometric, a, b, out.position);
                 });
}

}  // namespace regraft::shade
