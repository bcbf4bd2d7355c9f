#include "trace/compare.h"

#include <cmath>
#include <map>
#include <memory>

#include "regraft/trace/kernels.h"
#include "trace/brute_force.h"

namespace regraft::test {

namespace {

ChangeSet everything(const Scene& scene) {
  ChangeSet all;
  for (std::uint32_t id = 0; id < scene.meshes().size(); ++id)
    if (scene.meshes()[id].alive) all.added_meshes.push_back(id);
  all.instance_set_changed = true;
  return all;
}

std::string first_difference(std::span<const Ray> rays, std::span<const Found> wanted,
                             std::span<const Found> got) {
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (!(wanted[i] == got[i]))
      return text("ray ", i, ", ", rays[i], ": wanted ", wanted[i], ", got ", got[i]);
  return "";
}

std::string first_difference(std::span<const Ray> rays, std::span<const Found> wanted,
                             const std::vector<bool>& got) {
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (wanted[i].hit() != got[i])
      return text("any hit, ray ", i, ", ", rays[i], ": wanted ", wanted[i], ", got ", got[i]);
  return "";
}

}  // namespace

Executor& pool(unsigned threads) {
  static std::map<unsigned, std::unique_ptr<Executor>> pools;
  std::unique_ptr<Executor>& found = pools[threads];
  if (!found) found = std::make_unique<Executor>(threads);
  return *found;
}

std::uint32_t add_mesh(Scene& scene, const Geometry& g, const std::string& name) {
  return scene.add_mesh(g.data(), name);
}

std::uint32_t add_instance(Scene& scene, std::uint32_t mesh, const Mat4d& m) {
  Instance instance;
  instance.mesh = mesh;
  instance.object_to_world = m;
  return scene.add_instance(instance);
}

std::uint32_t add(Scene& scene, const Geometry& g, const Mat4d& m) {
  const std::uint32_t mesh = add_mesh(scene, g);
  add_instance(scene, mesh, m);
  return mesh;
}

std::vector<Found> hits_anew(const Scene& scene, std::span<const Ray> rays) {
  accel::Accelerator anew;
  accel::UpdateOptions options;
  options.policy = accel::Policy::rebuild;
  anew.update(scene, everything(scene), options, 4, pool(1));
  return brute_force(scene, anew.view(), rays);
}

std::string difference(const trace::TraceView& view, int width, std::span<const Ray> rays,
                       std::span<const Found> wanted) {
  for (const simd::Isa isa : simd::available_isas()) {
    if (trace::kernels(isa).width != width) continue;
    const trace::Tracer tracer(view, isa);
    for (const Entry entry : entries) {
      std::string error = first_difference(rays, wanted, closest_hits(tracer, rays, entry));
      if (error.empty()) error = first_difference(rays, wanted, any_hits(tracer, rays, entry));
      if (!error.empty()) return text(simd::name(isa), " ", name(entry), ": ", error);
    }
  }
  return "";
}

bool Interval::right(const Found& found) const {
  if (wanted == same) return found == before;
  return wanted == nothing ? !found.hit() : found.t > before.t;
}

std::vector<Interval> tight_intervals(std::span<const Ray> rays, std::span<const Found> hits) {
  std::vector<Interval> result;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i].hit()) continue;
    const float t = hits[i].t;
    const Ray& ray = rays[i];
    const auto within = [&](float near, float far) {
      return Ray{ray.origin, ray.direction, near, far};
    };
    result.push_back({within(t, ray.t_far), Interval::same, hits[i]});
    result.push_back({within(ray.t_near, t), Interval::same, hits[i]});
    result.push_back({within(t, t), Interval::same, hits[i]});
    result.push_back({within(ray.t_near, std::nextafter(t, -inf)), Interval::nothing, hits[i]});
    result.push_back({within(std::nextafter(t, inf), inf), Interval::later, hits[i]});
  }
  return result;
}

}  // namespace regraft::test
