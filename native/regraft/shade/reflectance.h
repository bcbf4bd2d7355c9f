#pragma once

#include "regraft/shade/lights.h"
#include "regraft/shade/surface.h"

namespace regraft::shade {

/// The materials of 64 surfaces.
struct MaterialLanes {
  Vec3Lanes base;
  Vec3Lanes emission;
  FloatLanes alpha, metallic, roughness;
};

void read_materials(const SurfaceLanes& surface, MaterialLanes& out);

/// How 64 surfaces scatter light; the part that no light changes.
struct ReflectanceLanes {
  Vec3Lanes diffuse;       ///< radiance per irradiance
  Vec3Lanes specular;      ///< colour of a mirror seen straight on
  FloatLanes edge;         ///< of the mirror at grazing angles
  FloatLanes width;        ///< GGX α
  FloatLanes normal_view;  ///< cosine between normal and view
};

/// Lambert's diffuse reflection and a restrained GGX highlight: it fades with roughness, so that a
/// surface of roughness 1 is purely diffuse, and never gets narrower than roughness 0.25, since
/// lights are points. A metal keeps a third of its diffuse colour, because a preview has no
/// surroundings to mirror in it. `mirrored`: share of the light that a mirror ray answers for.
void prepare_reflectance(const SurfaceLanes& surface, const MaterialLanes& material,
                         const FloatLanes& mirrored, ReflectanceLanes& out);

/// Adds what the surfaces send to the viewer of one light's illumination; `passed` is the share
/// of it that arrives. GGX distribution (Walter et al., EGSR 2007, eq. 33), Schlick's Fresnel
/// term, and the height-correlated shadowing term in Hammon's approximation (GDC 2017).
void add_light(const PreparedLight& light, const Illumination& illumination,
               const FloatLanes& passed, const SurfaceLanes& surface,
               const ReflectanceLanes& reflectance, Vec3Lanes& radiance);

/// Share of light mirrored towards the viewer: Schlick's Fresnel term for dielectrics, all of it
/// for metals, fading with roughness. What would not be seen is 0.
void mirror_share(const SurfaceLanes& surface, const MaterialLanes& material, FloatLanes& out);

}  // namespace regraft::shade
