#include "regraft/shade/reflectance.h"

#include <cmath>
#include <numbers>

namespace regraft::shade {

namespace {

constexpr float inverse_pi = std::numbers::inv_pi_v<float>;
/// Mirror of a dielectric seen straight on (index of refraction 1.5).
constexpr float dielectric = 0.04f;
constexpr float least_roughness = 0.25f;
/// Share of its base colour a metal reflects diffusely.
constexpr float metal_diffuse = 1.0f / 3.0f;
/// Mirrors weaker than this are not traced.
constexpr float least_mirror = 0.02f;

void set(MaterialLanes& out, std::uint32_t i, const Material& m) {
  out.base.x[i] = m.base_color.x;
  out.base.y[i] = m.base_color.y;
  out.base.z[i] = m.base_color.z;
  out.alpha[i] = m.base_color.w;
  out.emission.x[i] = m.emission.x;
  out.emission.y[i] = m.emission.y;
  out.emission.z[i] = m.emission.z;
  out.metallic[i] = m.metallic;
  out.roughness[i] = m.roughness;
}

void fill(MaterialLanes& out, const Material& m) {
  out.base.x.fill(m.base_color.x);
  out.base.y.fill(m.base_color.y);
  out.base.z.fill(m.base_color.z);
  out.alpha.fill(m.base_color.w);
  out.emission.x.fill(m.emission.x);
  out.emission.y.fill(m.emission.y);
  out.emission.z.fill(m.emission.z);
  out.metallic.fill(m.metallic);
  out.roughness.fill(m.roughness);
}

float normal_view(const SurfaceLanes& s, std::uint32_t i) {
  return s.normal.x[i] * s.view.x[i] + (s.normal.y[i] * s.view.y[i] + s.normal.z[i] * s.view.z[i]);
}

float power5(float x) {
  const float x2 = x * x;
  return x2 * x2 * x;
}

}  // namespace

void read_materials(const SurfaceLanes& surface, MaterialLanes& out) {
  if (surface.one_material) return fill(out, *surface.material[0]);
  for (std::uint32_t i = 0; i < lane_count; ++i) set(out, i, *surface.material[i]);
}

void prepare_reflectance(const SurfaceLanes& surface, const MaterialLanes& m,
                         const FloatLanes& mirrored, ReflectanceLanes& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float metal = m.metallic[i];
    const float diffuse =
        (1.0f - metal * (1.0f - metal_diffuse)) * (1.0f - mirrored[i]) * inverse_pi;
    const float gloss = 1.0f - m.roughness[i];
    const float specular = dielectric * (1.0f - metal) * gloss;
    out.diffuse.x[i] = m.base.x[i] * diffuse;
    out.diffuse.y[i] = m.base.y[i] * diffuse;
    out.diffuse.z[i] = m.base.z[i] * diffuse;
    out.specular.x[i] = specular + metal * m.base.x[i];
    out.specular.y[i] = specular + metal * m.base.y[i];
    out.specular.z[i] = specular + metal * m.base.z[i];
    out.edge[i] = gloss;
    const float roughness = max_of(m.roughness[i], least_roughness);
    out.width[i] = roughness * roughness;
    out.normal_view[i] = max_of(normal_view(surface, i), 1e-3f);
  }
}

void add_light(const PreparedLight& light, const Illumination& illumination,
               const FloatLanes& passed, const SurfaceLanes& s, const ReflectanceLanes& r,
               Vec3Lanes& radiance) {
  const Vec3 intensity = light.intensity;
  const Vec3Lanes& l = illumination.to_light;
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float energy = illumination.irradiance[i] * passed[i];
    const float nl =
        max_of(s.normal.x[i] * l.x[i] + (s.normal.y[i] * l.y[i] + s.normal.z[i] * l.z[i]), 1e-4f);
    const float nv = r.normal_view[i];
    const float lv = l.x[i] * s.view.x[i] + (l.y[i] * s.view.y[i] + l.z[i] * s.view.z[i]);
    // The half vector is (l + v) / |l + v|, and |l + v|² = 2 + 2 l·v.
    const float inverse = 1.0f / std::sqrt(max_of(2.0f + 2.0f * lv, 1e-6f));
    const float nh = min_of((nl + nv) * inverse, 1.0f);
    const float a = r.width[i], a2 = a * a;
    const float spread = nh * nh * (a2 - 1.0f) + 1.0f;
    const float ggx = a2 * inverse_pi / (spread * spread);
    const float visible = 0.5f / (2.0f * nl * nv * (1.0f - a) + (nl + nv) * a);
    const float lobe = ggx * visible;
    const float grazing = power5(1.0f - min_of((1.0f + lv) * inverse, 1.0f));
    const float edge = r.edge[i] * grazing, straight = 1.0f - grazing;
    radiance.x[i] +=
        energy * intensity.x * (r.diffuse.x[i] + lobe * (r.specular.x[i] * straight + edge));
    radiance.y[i] +=
        energy * intensity.y * (r.diffuse.y[i] + lobe * (r.specular.y[i] * straight + edge));
    radiance.z[i] +=
        energy * intensity.z * (r.diffuse.z[i] + lobe * (r.specular.z[i] * straight + edge));
  }
}

void mirror_share(const SurfaceLanes& surface, const MaterialLanes& m, FloatLanes& out) {
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    const float grazing = power5(1.0f - min_of(max_of(normal_view(surface, i), 0.0f), 1.0f));
    const float fresnel = dielectric + (1.0f - dielectric) * grazing;
    const float gloss = (1.0f - m.roughness[i]) * (1.0f - m.roughness[i]);
    const float share = gloss * (fresnel + m.metallic[i] * (1.0f - fresnel));
    out[i] = max_of(0.0f, (share - least_mirror) * (1.0f / (1.0f - least_mirror)));
  }
}

}  // namespace regraft::shade
