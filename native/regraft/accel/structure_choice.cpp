#include "regraft/accel/structure_choice.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

namespace regraft::accel {

namespace {

/// Fewer triangles than this are built into a BVH in the time a picture takes anyway, and nothing
/// need be said.
constexpr std::uint64_t many_triangles = 1'000'000;
/// Measured (docs/benchmarks.md): above this share a BVH's faster tracing makes up for its build.
constexpr double little = 0.25;
/// Vertices looked at, over all instances.
constexpr double samples = 8192.0;

bool shown(const Scene& scene, const Instance& instance) {
  return instance.alive && instance.visible && instance.mesh < scene.meshes().size() &&
         scene.meshes()[instance.mesh].alive;
}

/// Whether a point in the camera's frame is in its window.
bool in_window(const Camera& camera, const Vec3d& p) {
  double scale = 1.0;
  if (camera.kind == CameraKind::perspective) {
    if (!(p.z < 0.0)) return false;
    scale = -1.0 / p.z;
  } else if (camera.kind != CameraKind::orthographic) {
    return true;  // all around
  }
  return scale * p.x >= camera.window[0] && scale * p.x <= camera.window[1] &&
         scale * p.y >= camera.window[2] && scale * p.y <= camera.window[3];
}

/// Triangles that trees of meshes are built over: those of an instanced mesh count once.
std::uint64_t unique_triangles(const Scene& scene) {
  std::vector<std::uint8_t> used(scene.meshes().size(), 0);
  for (const Instance& instance : scene.instances())
    if (shown(scene, instance)) used[instance.mesh] = 1;
  std::uint64_t sum = 0;
  for (std::size_t id = 0; id < used.size(); ++id)
    if (used[id] != 0) sum += scene.meshes()[id].triangles.size();
  return sum;
}

std::string percent(double share) {
  return std::to_string(int(std::lround(100.0 * share))) + " %";
}

}  // namespace

double share_in_view(const Scene& scene, const Camera& camera) {
  double all = 0.0;
  for (const Instance& instance : scene.instances())
    if (shown(scene, instance)) all += double(scene.meshes()[instance.mesh].triangles.size());
  const Mat4d to_camera = glm::inverse(camera.camera_to_world);
  double seen = 0.0;
  for (const Instance& instance : scene.instances()) {
    if (!shown(scene, instance)) continue;
    const Mesh& mesh = scene.meshes()[instance.mesh];
    if (mesh.vertices.empty()) continue;
    const auto weight = double(mesh.triangles.size());
    const auto wanted = std::size_t(std::max(8.0, samples * weight / std::max(all, 1.0)));
    const std::size_t step = std::max<std::size_t>(1, mesh.vertices.size() / wanted);
    const Mat4d frame = to_camera * instance.object_to_world;
    std::size_t tried = 0, inside = 0;
    for (std::size_t v = step / 2; v < mesh.vertices.size(); v += step, ++tried)
      inside += in_window(camera, Vec3d(frame * glm::dvec4(Vec3d(mesh.vertices[v]), 1.0)));
    seen += weight * double(inside) / double(std::max<std::size_t>(tried, 1));
  }
  return all > 0.0 ? seen / all : 0.0;
}

StructureChoice choose_structure(const Scene& scene, const UpdateOptions& options,
                                 Structure present) {
  if (options.structure != Structure::automatic) return {options.structure, ""};
  if (present != Structure::automatic)
    return {present, present == Structure::kdtree ? "auto: the k-d tree is kept" : ""};
  const std::uint64_t triangles = unique_triangles(scene);
  if (triangles < many_triangles) return {Structure::bvh, ""};
  if (options.frames_left != 1)
    return {Structure::bvh, "auto: not known to be a single frame: no k-d tree"};
  if (!options.camera) return {Structure::bvh, "auto: no camera known: no k-d tree"};
  const double share = share_in_view(scene, *options.camera);
  const std::string why = "auto: a single frame with " + percent(share) + " of " +
                          std::to_string(triangles) + " triangles in view: ";
  if (share > little) return {Structure::bvh, why + "no k-d tree"};
  return {Structure::kdtree, why + "k-d tree, what no ray comes near is not built"};
}

}  // namespace regraft::accel
