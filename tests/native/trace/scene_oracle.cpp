#include "trace/scene_oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "trace/compare.h"

namespace regraft::test {

namespace {

/// Beyond this a world coordinate has no place in a float.
constexpr Real largest_coordinate = 1e37L;

struct WorldPoint {
  Vec3d position;
  Real magnitude;
};

WorldPoint to_world(const Mat4d& m, const Vec3& p) {
  WorldPoint world{Vec3d(0.0), 0};
  for (int r = 0; r < 3; ++r) {
    Real sum = m[3][r];
    Real linear = 0;
    for (int c = 0; c < 3; ++c) {
      sum += Real(m[c][r]) * p[c];
      linear += std::fabs(Real(m[c][r]) * p[c]);
    }
    world.position[r] = double(sum);
    world.magnitude = std::max(world.magnitude, linear);
  }
  return world;
}

bool can_be_met(const Instance& instance) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r)
      if (!std::isfinite(instance.object_to_world[c][r])) return false;
  return instance.alive && instance.visible;
}

void collect(const Scene& scene, std::uint32_t id, std::vector<WorldTriangle>& triangles) {
  const Instance& instance = scene.instances()[id];
  const Mesh& mesh = scene.meshes()[instance.mesh];
  Real magnitude = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (is_degenerate(mesh, t)) continue;
    WorldPoint p[3];
    for (int c = 0; c < 3; ++c) {
      p[c] = to_world(instance.object_to_world, mesh.vertices[mesh.triangles[t][c]]);
      magnitude = std::max(magnitude, p[c].magnitude);
    }
    const ExactTriangle corners{p[0].position, p[1].position, p[2].position};
    if (!std::isfinite(magnitude) || magnitude > largest_coordinate) continue;
    const Vec3d center = (corners.a + corners.b + corners.c) / 3.0;
    const double radius =
        std::max({glm::distance(center, corners.a), glm::distance(center, corners.b),
                  glm::distance(center, corners.c)});
    triangles.push_back({corners, id, t, 0, center, radius});
  }
  for (WorldTriangle& triangle : triangles)
    if (triangle.instance == id) triangle.magnitude = magnitude;
}

/// True if the line passes the triangle's ball by more than `allowed`.
bool passes_by(const Ray& ray, const WorldTriangle& t, double allowed) {
  const double speed = glm::length(ray.direction);
  return glm::length(glm::cross(t.center - ray.origin, ray.direction / speed)) >
         1.001 * t.radius + allowed;
}

Real largest(const Vec3r& v) {
  return std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
}

}  // namespace

SceneOracle::SceneOracle(const Scene& scene, double ulps) : relative_(Real(ulps) * 0x1p-23L) {
  for (std::uint32_t i = 0; i < scene.instances().size(); ++i)
    if (can_be_met(scene.instances()[i])) collect(scene, i, triangles_);
  if (triangles_.empty()) return;
  Vec3d lo(triangles_[0].corners.a), hi(lo);
  for (const WorldTriangle& t : triangles_)
    for (const Vec3d& p : {t.corners.a, t.corners.b, t.corners.c})
      for (int k = 0; k < 3; ++k) {
        lo[k] = std::min(lo[k], p[k]);
        hi[k] = std::max(hi[k], p[k]);
      }
  center_ = 0.5 * lo + 0.5 * hi;
  radius_ = glm::length(hi - center_);
}

Real SceneOracle::tolerance(const Ray& ray, Real magnitude) const {
  return relative_ * std::max({largest(subtract(ray.origin, center_)), Real(radius_), magnitude});
}

std::string SceneOracle::unsound(const Ray& ray, const Found& found) const {
  if (!(found.t >= ray.t_near && found.t <= ray.t_far))
    return text(found, " is outside the interval of ", ray);
  const auto hit = std::find_if(triangles_.begin(), triangles_.end(), [&](const auto& t) {
    return t.instance == found.instance && t.prim == found.prim;
  });
  if (hit == triangles_.end()) return text(found, " does not exist");
  const Real off = distance(along(ray.origin, found.t, ray.direction), hit->corners);
  const Real allowed = tolerance(ray, hit->magnitude);
  if (off <= allowed) return "";
  return text(found, " lies ", off, " off its triangle, ", allowed, " allowed, for ", ray);
}

std::string SceneOracle::missed(const Ray& ray, const Found& found) const {
  const Vec3d& d = ray.direction;
  const Real speed = length({d.x, d.y, d.z});
  for (const WorldTriangle& t : triangles_) {
    const Real allowed = tolerance(ray, t.magnitude);
    if (passes_by(ray, t, double(allowed))) continue;
    const Judgement j = judge(ray.origin, d, t.corners);
    if (j.verdict != Verdict::hit || !(j.margin > allowed)) continue;
    const Real slack = allowed / (j.cosine * speed) + std::fabs(j.t) * 0x1p-22L;
    const bool surely_within = j.t - slack > ray.t_near && j.t + slack < ray.t_far;
    if (surely_within && !(Real(found.t) <= j.t + slack))
      return text(found, " for ", ray, "; but instance ", t.instance, " triangle ", t.prim,
                  " is met at t ", j.t, " and passed ", j.margin, " from its edges, ", allowed,
                  " allowed");
  }
  return "";
}

const WorldTriangle* SceneOracle::surely_nearest(const Ray& ray, double margin) const {
  const WorldTriangle* nearest = nullptr;
  Real least = 0;
  for (const WorldTriangle& t : triangles_) {
    if (passes_by(ray, t, margin)) continue;
    const Judgement j = judge(ray.origin, ray.direction, t.corners);
    if (j.margin <= margin) return nullptr;
    if (j.verdict != Verdict::hit || j.t < 0 || (nearest != nullptr && j.t >= least)) continue;
    nearest = &t;
    least = j.t;
  }
  return nearest;
}

std::string SceneOracle::complaint(const Ray& ray, const Found& found) const {
  const std::string first = found.hit() ? unsound(ray, found) : "";
  return first.empty() ? missed(ray, found) : first;
}

namespace {

/// Aims at one triangle of the scene in one of many ways.
class Aim {
 public:
  Aim(const SceneOracle& oracle, Random& random)
      : oracle_(oracle),
        random_(random),
        target_(oracle.triangles()[random.below(oracle.triangles().size())].corners) {}

  Ray ray(std::size_t kind) {
    switch (kind % 12) {
      case 0:
        return towards(outside(), anywhere());
      case 1:
        return towards(outside(), target_.a);
      case 2:
        return towards(outside(), 0.5 * (target_.b + target_.c));
      case 3:
        return towards(outside(), inside());
      case 4:
        return {anywhere(), random_.way()};
      case 5:
        return towards(anywhere(), target_.b);
      case 6:
        return axis_parallel();
      case 7:
        return in_a_plane();
      case 8:
        return along_edge();
      case 9:
        return windowed();
      case 10:
        return scaled(towards(outside(), inside()));
      default:
        return {inside(), random_.way()};
    }
  }

 private:
  Vec3d anywhere() { return oracle_.center() + random_.in_box(oracle_.radius()); }
  Vec3d outside() {
    return oracle_.center() + random_.uniform(1.5, 4.0) * oracle_.radius() * random_.way();
  }
  Vec3d inside() {
    const double r = std::sqrt(random_.uniform(0, 1)), v = random_.uniform(0, 1);
    return (1 - r) * target_.a + r * (1 - v) * target_.b + r * v * target_.c;
  }
  static Ray towards(const Vec3d& from, const Vec3d& to) { return {from, to - from}; }

  double zero() { return random_.below(2) == 0 ? 0.0 : -0.0; }

  /// Two coordinates of the origin are those of a vertex, so planes of boxes hold the ray.
  Ray axis_parallel() {
    Ray ray{target_.a, {zero(), zero(), zero()}};
    const int axis = int(random_.below(3));
    const double sign = random_.below(2) == 0 ? 1.0 : -1.0;
    ray.direction[axis] = sign;
    if (random_.below(4) != 0)
      ray.origin[axis] = oracle_.center()[axis] - sign * 2 * oracle_.radius();
    if (random_.below(2) == 0) ray.origin[(axis + 1) % 3] = target_.b[(axis + 1) % 3];
    return ray;
  }

  Ray in_a_plane() {
    Ray ray = towards(outside(), inside());
    const int axis = int(random_.below(3));
    ray.origin[axis] = target_.c[axis];
    ray.direction[axis] = zero();
    return ray;
  }

  Ray along_edge() {
    const Vec3d edge = target_.b - target_.a;
    const Vec3d from = target_.a - random_.uniform(0.0, 3.0) * edge;
    Ray ray{from, edge};
    if (random_.below(2) == 0) ray.direction += 1e-7 * glm::length(edge) * random_.way();
    return ray;
  }

  Ray windowed() {
    Ray ray = towards(outside(), inside());
    ray.t_near = float(random_.uniform(0.0, 1.0));
    ray.t_far = float(random_.uniform(0.5, 1.5));
    return ray;
  }

  Ray scaled(Ray ray) {
    ray.direction *= std::pow(10.0, random_.uniform(-12.0, 12.0)) / glm::length(ray.direction);
    return ray;
  }

  const SceneOracle& oracle_;
  Random& random_;
  ExactTriangle target_;
};

}  // namespace

std::vector<Ray> nasty_rays(const SceneOracle& oracle, std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    if (oracle.triangles().empty()) {
      rays.push_back({random.in_box(1.0), random.way()});
      continue;
    }
    rays.push_back(Aim(oracle, random).ray(random.below(12)));
  }
  return rays;
}

}  // namespace regraft::test
