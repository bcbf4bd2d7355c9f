#include "regraft/shade/surface.h"

#include <cmath>

#include "regraft/shade/corners.h"

namespace regraft::shade {

namespace {

/// Offsets secondary rays by this share of the coordinates they were computed from: the triangle
/// test's rounding error is 2^-20.4 of them (numerics rule N7; Wächter and Binder, "A Fast and
/// Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, 2019, offset by 2^-15 since
/// they reconstruct the position in world space and single precision).
constexpr float offset_ratio = 0x1p-18f;
/// The same for the instance's place in the world, which is added in double.
constexpr float translation_ratio = 0x1p-46f;

/// Object-space results.
struct LocalSurface {
  Vec3Lanes point;
  Vec3Lanes geometric;  ///< not a unit vector
  Vec3Lanes normal;     ///< neither; zero where the triangle is flat
  FloatLanes size;      ///< of the coordinates `point` was computed from
};

float largest(float x, float y, float z) {
  return max_of(max_of(std::fabs(x), std::fabs(y)), std::fabs(z));
}

/// Hit points and triangle normals. Edges are scaled to size one first: their product then
/// neither overflows nor vanishes.
void interpolate(const Corners& c, LocalSurface& out) {
  const Vec3Lanes &p = c.point[0], &q = c.point[1], &r = c.point[2];
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float px = p.x[i], py = p.y[i], pz = p.z[i], u = c.u[i], v = c.v[i];
    const float ax = q.x[i] - px, ay = q.y[i] - py, az = q.z[i] - pz;
    const float bx = r.x[i] - px, by = r.y[i] - py, bz = r.z[i] - pz;
    out.point.x[i] = px + (u * ax + v * bx);
    out.point.y[i] = py + (u * ay + v * by);
    out.point.z[i] = pz + (u * az + v * bz);
    const float size_a = largest(ax, ay, az), size_b = largest(bx, by, bz);
    out.size[i] = largest(px, py, pz) + (size_a + size_b);
    const float sa = 1.0f / max_of(size_a, 1e-37f), sb = 1.0f / max_of(size_b, 1e-37f);
    out.geometric.x[i] = (ay * sa) * (bz * sb) - (az * sa) * (by * sb);
    out.geometric.y[i] = (az * sa) * (bx * sb) - (ax * sa) * (bz * sb);
    out.geometric.z[i] = (ax * sa) * (by * sb) - (ay * sa) * (bx * sb);
  }
}

void interpolate_normals(const Corners& c, LocalSurface& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float u = c.u[i], v = c.v[i], w = 1.0f - u - v;
    out.normal.x[i] = w * c.normal[0].x[i] + (u * c.normal[1].x[i] + v * c.normal[2].x[i]);
    out.normal.y[i] = w * c.normal[0].y[i] + (u * c.normal[1].y[i] + v * c.normal[2].y[i]);
    out.normal.z[i] = w * c.normal[0].z[i] + (u * c.normal[1].z[i] + v * c.normal[2].z[i]);
  }
}

/// A direction in object space.
struct Direction {
  float x, y, z;
};

/// What is perpendicular, in the world, to planes with the object-space normal n; its component
/// along n is 1.
template <bool Conformal>
inline Direction perpendicular(const ShadedInstance& instance, const Direction& n) {
  if constexpr (Conformal) return n;
  const auto& m = instance.metric;
  const Direction d{m[0][0] * n.x + (m[0][1] * n.y + m[0][2] * n.z),
                    m[1][0] * n.x + (m[1][1] * n.y + m[1][2] * n.z),
                    m[2][0] * n.x + (m[2][1] * n.y + m[2][2] * n.z)};
  const float scale = 1.0f / max_of(n.x * d.x + (n.y * d.y + n.z * d.z), 1e-20f);
  return {d.x * scale, d.y * scale, d.z * scale};
}

/// Adds the step that lifts a point onto the tangent plane of corner k, if it is below, times
/// the corner's weight.
template <bool Conformal>
inline void lift(const ShadedInstance& instance, const Corners& c, int k, std::uint32_t i,
                 float side, float weight, const Direction& at, Direction& sum) {
  const Direction n{c.normal[k].x[i], c.normal[k].y[i], c.normal[k].z[i]};
  const float below =
      min_of(side * ((at.x - c.point[k].x[i]) * n.x +
                     ((at.y - c.point[k].y[i]) * n.y + (at.z - c.point[k].z[i]) * n.z)),
             0.0f);
  const Direction up = perpendicular<Conformal>(instance, n);
  const float step = side * weight * below;
  sum.x -= step * up.x;
  sum.y -= step * up.y;
  sum.z -= step * up.z;
}

/// Lifts hit points from the triangle to the curved surface its normals stand for, so that its
/// own facets do not shadow it: Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II,
/// 2021, section 4.3. `side` is −1 where the back of the triangle is seen. Ours: done in object
/// space, perpendicularly as the world sees it.
template <bool Conformal>
void lift_to_curved(const ShadedInstance& instance, const Corners& c, const FloatLanes& side,
                    std::uint32_t begin, std::uint32_t end, Vec3Lanes& point) {
  for (std::uint32_t i = begin; i < end; ++i) {
    const Direction at{point.x[i], point.y[i], point.z[i]};
    Direction sum = at;
    const float u = c.u[i], v = c.v[i];
    lift<Conformal>(instance, c, 0, i, side[i], 1.0f - u - v, at, sum);
    lift<Conformal>(instance, c, 1, i, side[i], u, at, sum);
    lift<Conformal>(instance, c, 2, i, side[i], v, at, sum);
    point.x[i] = sum.x;
    point.y[i] = sum.y;
    point.z[i] = sum.z;
  }
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
void finish_normals(const FloatLanes& side, SurfaceLanes& s) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float nx = s.normal.x[i], ny = s.normal.y[i], nz = s.normal.z[i];
    const float gx = s.geometric.x[i], gy = s.geometric.y[i], gz = s.geometric.z[i];
    const float vx = s.view.x[i], vy = s.view.y[i], vz = s.view.z[i];
    const float length2 = nx * nx + (ny * ny + nz * nz);
    const bool valid = length2 > 1e-12f;
    const float scale = side[i] / std::sqrt(max_of(length2, 1e-12f));
    const float x = valid ? nx * scale : gx;
    const float y = valid ? ny * scale : gy;
    const float z = valid ? nz * scale : gz;
    const float bend = max_of(0.01f - (x * vx + (y * vy + z * vz)), 0.0f);
    const float bx = x + bend * vx, by = y + bend * vy, bz = z + bend * vz;
    const float unit = 1.0f / std::sqrt(max_of(bx * bx + (by * by + bz * bz), 1e-12f));
    s.normal.x[i] = bx * unit;
    s.normal.y[i] = by * unit;
    s.normal.z[i] = bz * unit;
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

/// True if all lanes are of one material slot of one instance, which is what most packets see.
bool one_slot(const Corners& corners, const ShadedInstance& instance) {
  if (!corners.one_instance || instance.slots == nullptr) return corners.one_instance;
  std::uint32_t differing = 0;
  const std::uint16_t first = instance.slots[corners.prim_id[0]];
  for (const std::uint32_t prim : corners.prim_id.value) differing |= instance.slots[prim] ^ first;
  return differing == 0;
}

void find_materials(const Corners& corners, InstanceCache& instances, SurfaceLanes& out) {
  const auto material_of = [&](std::uint32_t i) {
    return &instances.material(instances.find(corners.instance_id[i]), corners.prim_id[i]);
  };
  out.material[0] = material_of(0);
  out.one_material = one_slot(corners, instances.find(corners.instance_id[0]));
  if (out.one_material) return;
  for (std::uint32_t i = 1; i < lane_count; ++i) out.material[i] = material_of(i);
}

void find_normals(const trace::RayPacket& rays, const Corners& corners, const LocalSurface& local,
                  InstanceCache& instances, FloatLanes& side, SurfaceLanes& out) {
  set_views(rays, out.view);
  for_each_run(corners, instances,
               [&](const ShadedInstance& m, std::uint32_t begin, std::uint32_t end) {
                 transform_normals(m, local.geometric, begin, end, out.geometric);
                 if (corners.smooth) transform_normals(m, local.normal, begin, end, out.normal);
               });
  face_viewer(out.view, out.geometric, side);
  if (corners.smooth)
    finish_normals(side, out);
  else
    out.normal = out.geometric;
}

}  // namespace

void find_surfaces(const trace::RayPacket& rays, const trace::HitPacket& hits, LaneMask active,
                   SurfaceNeeds needs, InstanceCache& instances, SurfaceLanes& out) {
  Corners corners;
  LocalSurface local;
  FloatLanes side;
  out.active = active;
  read_corners(hits, active, instances, corners);
  interpolate(corners, local);
  if (corners.smooth) interpolate_normals(corners, local);
  find_normals(rays, corners, local, instances, side, out);
  if (needs.materials) find_materials(corners, instances, out);
  if (!needs.positions) return;
  for_each_run(corners, instances,
               [&](const ShadedInstance& m, std::uint32_t begin, std::uint32_t end) {
                 if (corners.smooth && m.conformal)
                   lift_to_curved<true>(m, corners, side, begin, end, local.point);
                 else if (corners.smooth)
                   lift_to_curved<false>(m, corners, side, begin, end, local.point);
                 place(m, local, out.geometric, begin, end, out.position);
               });
}

}  // namespace regraft::shade
