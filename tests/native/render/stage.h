#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

#include "regraft/render/renderer.h"

namespace regraft::test {

/// Triangles to be put on a stage; smooth: vertices are shading normals too.
struct Shape {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  bool smooth = false;
};

/// A square in the plane z, facing up.
inline Shape square(float half, float z = 0.0f) {
  return {{{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}},
          {{0, 1, 2}, {0, 2, 3}}};
}

/// A closed sphere of `rings` × 2·`rings` faces about the origin.
inline Shape ball(unsigned rings, float radius = 1.0f, bool smooth = false) {
  const unsigned columns = 2 * rings;
  Shape shape;
  shape.smooth = smooth;
  for (unsigned j = 0; j <= rings; ++j)
    for (unsigned i = 0; i < columns; ++i) {
      const double down = std::numbers::pi * j / rings, round = std::numbers::pi * i / rings;
      shape.vertices.push_back(
          Vec3(double(radius) * Vec3d(std::sin(down) * std::cos(round),
                                      std::sin(down) * std::sin(round), std::cos(down))));
    }
  for (unsigned j = 0; j < rings; ++j)
    for (unsigned i = 0; i < columns; ++i) {
      const unsigned a = j * columns + i, b = j * columns + (i + 1) % columns;
      if (j > 0) shape.triangles.push_back({a, a + columns, b});
      if (j + 1 < rings) shape.triangles.push_back({b, a + columns, b + columns});
    }
  return shape;
}

inline Mat4d placed(const Vec3d& at, const Vec3d& scale = Vec3d(1.0)) {
  Mat4d m(1.0);
  for (int k = 0; k < 3; ++k) m[k][k] = scale[k];
  m[3] = {at, 1.0};
  return m;
}

inline Mat4d looking(const Vec3d& eye, const Vec3d& target) {
  const Vec3d back = glm::normalize(eye - target);
  const Vec3d aside = std::fabs(back.z) < 0.99 ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
  const Vec3d right = glm::normalize(glm::cross(aside, back));
  Mat4d m(1.0);
  m[0] = {right, 0.0};
  m[1] = {glm::cross(back, right), 0.0};
  m[2] = {back, 0.0};
  m[3] = {eye, 1.0};
  return m;
}

/// A square picture, 2·`half` wide one unit before the eye.
inline Camera perspective(const Vec3d& eye, const Vec3d& target, double half = 0.5) {
  Camera camera;
  camera.camera_to_world = looking(eye, target);
  camera.window = {-half, half, -half, half};
  return camera;
}

/// Straight down from `height`: image right is +X, image up +Y.
inline Camera from_above(double half, double height = 10.0) {
  Camera camera;
  camera.kind = CameraKind::orthographic;
  camera.camera_to_world = placed({0.0, 0.0, height});
  camera.window = {-half, half, -half, half};
  return camera;
}

inline Material plain(const Vec3& color, float alpha = 1.0f) {
  Material material;
  material.base_color = {color, alpha};
  material.roughness = 1.0f;
  return material;
}

/// A scene under a black sky, all of it white and perfectly diffuse unless said otherwise.
struct Stage {
  render::Renderer renderer;

  explicit Stage(unsigned threads = 2, simd::Isa isa = simd::best_isa()) : renderer(threads, isa) {
    renderer.scene().set_world(Vec3(0.0f));
    renderer.scene().set_materials({plain(Vec3(1.0f))});
  }

  std::uint32_t add(const Shape& shape, const Mat4d& at = Mat4d(1.0),
                    std::vector<std::uint32_t> materials = {0}, std::uint32_t object_index = 0) {
    MeshData data;
    data.vertices = shape.vertices;
    data.triangles = shape.triangles;
    if (shape.smooth) data.normal_ids = shape.triangles;
    Instance instance;
    instance.mesh = renderer.scene().add_mesh(data, "");
    instance.object_to_world = at;
    instance.material_list = renderer.scene().material_list(materials);
    instance.object_index = object_index;
    return renderer.scene().add_instance(instance);
  }

  void light(const Light& light) { renderer.scene().set_lights({light}); }

  render::Frame picture(const Camera& camera, const render::RenderSettings& settings) {
    renderer.update({});
    return renderer.render(camera, settings);
  }
};

inline render::RenderSettings sized(std::uint32_t width, std::uint32_t height,
                                    render::Shading shading = render::Shading::direct) {
  render::RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.shading = shading;
  return settings;
}

inline Light point_light(const Vec3d& at, float energy) {
  Light light;
  light.position = at;
  light.energy = energy;
  return light;
}

inline Light sun(const Vec3d& direction, float energy) {
  Light light;
  light.kind = LightKind::sun;
  light.direction = glm::normalize(direction);
  light.energy = energy;
  return light;
}

/// Red channel of the combined plane.
inline float red(const render::Frame& frame, std::uint32_t x, std::uint32_t y) {
  return frame.passes.at("combined").pixel(x, y)[0];
}

inline bool all_finite(const shade::Image& image) {
  for (const float value : image.pixels)
    if (!std::isfinite(value)) return false;
  return true;
}

/// Equal bit for bit, -0 and 0 told apart.
inline bool same_pixels(const shade::Image& a, const shade::Image& b) {
  return a.width == b.width && a.height == b.height && a.channels == b.channels &&
         a.pixels.size() == b.pixels.size() &&
         std::equal(a.pixels.begin(), a.pixels.end(), b.pixels.begin(), [](float x, float y) {
           return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
         });
}

}  // namespace regraft::test
