#include "read_dataclass.h"

#include <utility>

namespace regraft::bindings {

namespace {

/// The attributes of one object; `owner` is what messages call it.
class Attributes {
 public:
  Attributes(py::object object, std::string owner)
      : object_(std::move(object)), owner_(std::move(owner)) {}

  py::object get(const char* name) const {
    if (!py::hasattr(object_, name)) {
      throw py::value_error(owner_ + ": has no attribute " + name + "; a regraft." +
                            owner_.substr(0, owner_.find('[')) + " wanted");
    }
    return object_.attr(name);
  }
  std::string label(const char* name) const { return owner_ + "." + name; }
  double number(const char* name) const { return checked_number(get(name), label(name)); }
  template <std::size_t count>
  std::array<double, count> numbers(const char* name) const {
    return checked_numbers<count>(get(name), label(name));
  }
  Vec3d vector(const char* name) const {
    const auto v = numbers<3>(name);
    return {v[0], v[1], v[2]};
  }

  /// The value of an enumeration, by the attribute `kind`.
  template <typename Kind, std::size_t N>
  Kind kind(const std::pair<const char*, Kind> (&kinds)[N]) const {
    const auto text = py::str(get("kind")).cast<std::string>();
    std::string known;
    for (const auto& [name, value] : kinds) {
      if (text == name) return value;
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    throw py::value_error(label("kind") + ": \"" + text + "\" is none of " + known);
  }

 private:
  py::object object_;
  std::string owner_;
};

constexpr std::pair<const char*, CameraKind> camera_kinds[] = {
    {"perspective", CameraKind::perspective},
    {"orthographic", CameraKind::orthographic},
    {"equirectangular", CameraKind::equirectangular},
    {"fisheye_equidistant", CameraKind::fisheye_equidistant},
    {"fisheye_equisolid", CameraKind::fisheye_equisolid}};

constexpr std::pair<const char*, LightKind> light_kinds[] = {{"point", LightKind::point},
                                                             {"spot", LightKind::spot},
                                                             {"sun", LightKind::sun},
                                                             {"area", LightKind::area}};

Light read_light(const Attributes& from) {
  Light light;
  light.kind = from.kind(light_kinds);
  light.position = from.vector("position");
  light.direction = from.vector("direction");
  light.color = from.vector("color");
  light.energy = static_cast<float>(from.number("energy"));
  light.radius = static_cast<float>(from.number("radius"));
  light.spot_angle = static_cast<float>(from.number("spot_angle"));
  light.spot_blend = static_cast<float>(from.number("spot_blend"));
  light.axis_x = from.vector("axis_x");
  light.axis_y = from.vector("axis_y");
  const auto size = from.numbers<2>("size");
  light.size = Vec2(size[0], size[1]);
  light.cast_shadow = py::bool_(from.get("cast_shadow"));
  return light;
}

}  // namespace

Camera read_camera(const py::object& object) {
  const Attributes from(object, "Camera");
  Camera camera;
  camera.kind = from.kind(camera_kinds);
  camera.camera_to_world = checked_matrix(from.get("matrix"), from.label("matrix"));
  camera.window = from.numbers<4>("window");
  camera.clip_near = from.number("clip_near");
  camera.clip_far = from.number("clip_far");
  camera.latitude = from.numbers<2>("latitude");
  camera.longitude = from.numbers<2>("longitude");
  camera.fov = from.number("fov");
  return camera;
}

std::vector<Light> read_lights(const py::object& lights) {
  if (!py::isinstance<py::sequence>(lights)) {
    throw py::value_error("lights: a sequence of regraft.Light wanted");
  }
  std::vector<Light> result;
  for (const py::handle light : lights) {
    const std::string owner = "Light[" + std::to_string(result.size()) + "]";
    result.push_back(read_light({py::reinterpret_borrow<py::object>(light), owner}));
  }
  return result;
}

}  // namespace regraft::bindings
