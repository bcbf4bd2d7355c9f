#pragma once

#include <array>
#include <cstdint>

#include "regraft/accel/accelerator.h"
#include "regraft/scene/scene.h"

namespace regraft::shade {

/// What shading reads of an instance, gathered when a ray first hits it.
struct ShadedInstance {
  std::uint32_t id = invalid_id;
  const Instance* instance = nullptr;
  const Vec3* vertices = nullptr;
  const Triangle* triangles = nullptr;
  const std::uint16_t* slots = nullptr;    ///< null: all 0
  const glm::uvec3* normal_ids = nullptr;  ///< null: flat
  const Vec3* normals = nullptr;           ///< by normal id, object space
  double rotation[3][3];                   ///< object to world, row-major
  double translation[3];
  /// Takes object-space normals to the world: cofactors of `rotation` times the sign of its
  /// determinant, largest one ±1. Unlike the inverse transpose they exist for flattened instances.
  float cofactor[3][3];
  /// Inverse metric of object space, cofactorᵀ · cofactor up to scale: takes a plane's normal to
  /// the direction that is perpendicular to the plane in the world. `conformal`: it is a multiple
  /// of the identity, as for all rigid motions and even scales.
  float metric[3][3];
  bool conformal = true;
  /// World length of the longest image of an object-space unit vector's component.
  float stretch = 0.0f;
  float translation_size = 0.0f;    ///< largest |component|
  std::uint32_t slot = invalid_id;  ///< the one `material` belongs to
  const Material* material = nullptr;
};

/// The instances that were hit last. One a worker; nothing is done for instances nobody sees.
class InstanceCache {
 public:
  InstanceCache(const Scene& scene, const accel::Accelerator& accelerator)
      : scene_(&scene), accelerator_(&accelerator) {}

  /// Valid until an instance with the same id modulo `slot_count` is asked for.
  const ShadedInstance& find(std::uint32_t id) {
    ShadedInstance& entry = entries_[id % slot_count];
    if (entry.id != id) load(entry, id);
    return entry;
  }
  const Material& material(const ShadedInstance& entry, std::uint32_t prim_id) {
    const std::uint32_t slot = entry.slots != nullptr ? entry.slots[prim_id] : 0;
    return entry.slot == slot ? *entry.material : load_material(entry, slot);
  }
  /// Whether any instance asked for so far has shading normals.
  bool met_smooth() const { return met_smooth_; }

 private:
  static constexpr std::uint32_t slot_count = 32;
  void load(ShadedInstance& entry, std::uint32_t id);
  const Material& load_material(const ShadedInstance& entry, std::uint32_t slot);

  const Scene* scene_;
  const accel::Accelerator* accelerator_;
  bool met_smooth_ = false;
  std::array<ShadedInstance, slot_count> entries_;
};

}  // namespace regraft::shade
