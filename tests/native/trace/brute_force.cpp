#define REGRAFT_SIMD_SCALAR
#include "trace/brute_force.h"

#include "regraft/trace/traverse_bvh.h"

namespace regraft::test {

namespace {

using trace::InstanceView;
using trace::scalar::LocalRay;
using trace::scalar::Nearest;

/// The triangles of an instance that have an area.
std::vector<std::uint32_t> whole_triangles(const Scene& scene, const InstanceView& instance) {
  const Mesh& mesh = scene.meshes()[scene.instances()[instance.instance_id].mesh];
  std::vector<std::uint32_t> whole;
  Mesh single;
  single.vertices.resize(3);
  single.triangles = {{0, 1, 2}};
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const float* p =
          instance.mesh.vertices + 3 * std::size_t(instance.mesh.triangles[3 * t + unsigned(c)]);
      single.vertices[std::size_t(c)] = {p[0], p[1], p[2]};
    }
    if (!is_degenerate(single, 0)) whole.push_back(t);
  }
  return whole;
}

template <int Axis>
void test_all(const LocalRay& local, const InstanceView& instance,
              std::span<const std::uint32_t> prims, float t_far, Nearest& nearest) {
  const float limit = local_limit(local, t_far);
  for (const std::uint32_t prim : prims)
    trace::scalar::test_triangles<Axis>(local, instance.mesh, &prim, 1, limit,
                                        [&](int, float t, float u, float v) {
                                          if (nearest.beaten_by(t, instance.instance_id, prim))
                                            nearest = {t, instance.instance_id, prim, u, v};
                                        });
}

void test_instance(const trace::TraceView& view, const trace::scalar::WorldRay& world,
                   const InstanceView& instance, std::span<const std::uint32_t> prims,
                   Nearest& nearest) {
  LocalRay local;
  if (!make_local(world, make_top(view, world), instance, local)) return;
  const auto test = local.kz == 0 ? &test_all<0> : local.kz == 1 ? &test_all<1> : &test_all<2>;
  test(local, instance, prims, world.t_far, nearest);
}

}  // namespace

std::vector<Found> brute_force(const Scene& scene, const trace::TraceView& view,
                               std::span<const Ray> rays) {
  std::vector<std::vector<std::uint32_t>> prims(view.instance_count);
  for (std::uint32_t i = 0; i < view.instance_count; ++i)
    if (view.instances[i].mesh.nodes != nullptr)
      prims[i] = whole_triangles(scene, view.instances[i]);
  std::vector<Found> result;
  for (const Ray& ray : rays) {
    trace::scalar::WorldRay world;
    for (int k = 0; k < 3; ++k) {
      world.origin[k] = ray.origin[k];
      world.direction[k] = ray.direction[k];
    }
    world.t_near = ray.t_near;
    world.t_far = ray.t_far;
    Nearest nearest{ray.t_far, invalid_id, invalid_id, 0.0f, 0.0f};
    for (std::uint32_t i = 0; i < view.instance_count && valid(world); ++i)
      test_instance(view, world, view.instances[i], prims[i], nearest);
    const float t = nearest.prim_id == invalid_id ? inf : nearest.t;
    result.push_back({t, nearest.instance_id, nearest.prim_id, nearest.u, nearest.v});
  }
  return result;
}

}  // namespace regraft::test
