#include "regraft/shade/reflectance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace regraft::shade {
namespace {

using std::numbers::pi;

/// 64 surfaces that face up, seen at angles from straight on to grazing.
struct Bench {
  std::unique_ptr<SurfaceLanes> surface = std::make_unique<SurfaceLanes>();
  std::unique_ptr<MaterialLanes> materials = std::make_unique<MaterialLanes>();
  std::unique_ptr<ReflectanceLanes> reflectance = std::make_unique<ReflectanceLanes>();
  FloatLanes none;

  explicit Bench(const Material& material) {
    none.fill(0.0f);
    surface->active = all_lanes;
    surface->normal.x.fill(0.0f);
    surface->normal.y.fill(0.0f);
    surface->normal.z.fill(1.0f);
    for (std::uint32_t i = 0; i < lane_count; ++i) {
      const double angle = i / 64.0 * pi / 2;
      surface->view.x[i] = float(std::sin(angle));
      surface->view.y[i] = 0.0f;
      surface->view.z[i] = float(std::cos(angle));
      surface->material[i] = &material;
    }
    surface->one_material = true;
    read_materials(*surface, *materials);
    prepare_reflectance(*surface, *materials, none, *reflectance);
  }

  /// Radiance towards the viewers for light of `irradiance` from a direction.
  Vec3Lanes lit(const Vec3& from, float irradiance) {
    PreparedLight light;
    light.intensity = Vec3(1.0f);
    auto illumination = std::make_unique<Illumination>();
    illumination->to_light.x.fill(from.x);
    illumination->to_light.y.fill(from.y);
    illumination->to_light.z.fill(from.z);
    illumination->irradiance.fill(irradiance);
    FloatLanes passed;
    passed.fill(1.0f);
    Vec3Lanes radiance{};
    add_light(light, *illumination, passed, *surface, *reflectance, radiance);
    return radiance;
  }

  /// Share of the light from an evenly bright hemisphere that each viewer gets back.
  std::vector<double> furnace() {
    std::vector<double> sum(lane_count, 0.0);
    const int rings = 64, columns = 128;
    for (int j = 0; j < rings; ++j)
      for (int k = 0; k < columns; ++k) {
        const double r2 = (j + 0.5) / rings, around = 2 * pi * (k + 0.5) / columns;
        const Vec3 from(float(std::sqrt(r2) * std::cos(around)),
                        float(std::sqrt(r2) * std::sin(around)), float(std::sqrt(1 - r2)));
        const Vec3Lanes radiance = lit(from, float(pi / (rings * columns)));
        for (std::uint32_t i = 0; i < lane_count; ++i) sum[i] += double(radiance.x[i]);
      }
    return sum;
  }
};

Material made(float roughness, float metallic) {
  Material material;
  material.base_color = Vec4(1.0f);
  material.roughness = roughness;
  material.metallic = metallic;
  return material;
}

TEST(Reflectance, RoughnessOneIsPurelyDiffuse) {
  Material material = made(1.0f, 0.0f);
  material.base_color = {0.5f, 0.25f, 0.125f, 1.0f};
  const Vec3Lanes radiance = Bench(material).lit({0.6f, 0.0f, 0.8f}, float(pi));
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    EXPECT_NEAR(radiance.x[i], 0.5f, 1e-6f);
    EXPECT_NEAR(radiance.y[i], 0.25f, 1e-6f);
    EXPECT_NEAR(radiance.z[i], 0.125f, 1e-6f);
  }
}

TEST(Reflectance, NoMaterialGivesBackMuchMoreThanItGets) {
  // A preview lays its highlight over the diffuse light instead of taking it from there, and a
  // metal keeps a third: bounded, not conserved. Grazing views of the lobe are the worst.
  for (const float metallic : {0.0f, 0.5f, 1.0f})
    for (const float roughness : {0.3f, 0.5f, 0.75f, 1.0f}) {
      const auto returned = Bench(made(roughness, metallic)).furnace();
      for (std::uint32_t i = 0; i < 56; ++i) {
        EXPECT_LT(returned[i], 1.45)
            << "roughness " << roughness << " metallic " << metallic << " view " << i;
        EXPECT_GT(returned[i], 0.3);
      }
    }
}

TEST(Reflectance, TheHighlightIsAtTheMirrorAngleAndFadesWithRoughness) {
  float last = std::numeric_limits<float>::infinity();
  for (const float roughness : {0.25f, 0.5f, 0.75f, 1.0f}) {
    const Vec3Lanes radiance =
        Bench(made(roughness, 0.0f)).lit({-std::sin(0.5f), 0.0f, std::cos(0.5f)}, 1.0f);
    const std::uint32_t mirror = std::uint32_t(0.5 / (pi / 2) * 64);
    const float highlight = radiance.x[mirror] - float(1.0 / pi);
    EXPECT_GE(highlight, -1e-6f);
    EXPECT_LT(highlight, last);
    if (roughness < 0.6f) {
      EXPECT_GT(radiance.x[mirror], radiance.x[mirror + 20]);
    }
    last = highlight;
  }
}

TEST(Reflectance, SmootherThanALampCanShowIsNotNarrower) {
  const Vec3 from(-std::sin(0.5f), 0.0f, std::cos(0.5f));
  const Vec3Lanes mirror = Bench(made(0.0f, 1.0f)).lit(from, 1.0f);
  for (const float value : mirror.x.value) {
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_LT(value, 200.0f);
  }
}

TEST(Reflectance, WhatIsMirroredIsNotDiffuse) {
  const Material material = made(1.0f, 0.0f);
  Bench bench(material);
  FloatLanes half;
  half.fill(0.5f);
  prepare_reflectance(*bench.surface, *bench.materials, half, *bench.reflectance);
  EXPECT_NEAR(bench.lit({0, 0, 1}, float(pi)).x[10], 0.5f, 1e-6f);
}

TEST(Reflectance, MirrorsAreFresnelsAndFadeWithRoughness) {
  FloatLanes glass, rough, metal;
  const Material smooth = made(0.0f, 0.0f), matt = made(1.0f, 0.0f), steel = made(0.0f, 1.0f);
  Bench a(smooth), b(matt), c(steel);
  mirror_share(*a.surface, *a.materials, glass);
  mirror_share(*b.surface, *b.materials, rough);
  mirror_share(*c.surface, *c.materials, metal);
  EXPECT_NEAR(glass[0], (0.04f - 0.02f) / 0.98f, 1e-5f);
  for (std::uint32_t i = 0; i < lane_count; ++i) {
    EXPECT_EQ(rough[i], 0.0f);
    EXPECT_NEAR(metal[i], 1.0f, 1e-5f);
    if (i > 0) {
      EXPECT_GE(glass[i], glass[i - 1]);
    }
  }
  EXPECT_GT(glass[63], 0.8f);
}

}  // namespace
}  // namespace regraft::shade
