#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace regraft {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Vec3d = glm::dvec3;
using Mat3d = glm::dmat3;
/// Column-major, column vectors: `world = m * Vec4d(object, 1)`.
using Mat4d = glm::dmat4;

/// Id of nothing: a miss, no group, no material.
inline constexpr unsigned invalid_id = 0xFFFFFFFFu;

}  // namespace regraft
