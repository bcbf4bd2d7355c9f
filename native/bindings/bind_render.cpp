#include <pybind11/stl.h>

#include <limits>
#include <mutex>
#include <optional>

#include "args.h"
#include "bindings.h"
#include "python_poll.h"
#include "read_dataclass.h"
#include "statistics.h"

namespace regraft::bindings {

namespace {

using PassesArg = Arg<"collections.abc.Sequence[str]">;
using RegionArg = Arg<"tuple[int, int, int, int]">;
using PassesDict = Arg<"dict[str, numpy.typing.NDArray[numpy.float32]]">;
using ProgressArg = Arg<"collections.abc.Callable[[float], typing.Any]">;
using CancelArg = Arg<"collections.abc.Callable[[], bool]">;

struct Frame {
  PassesDict passes;
  FrameStatistics statistics;
  bool cancelled = false;
};

/// (H, W, C) view of an image that it owns: first row on top, so of negative stride.
py::array_t<float> image_array(shade::Image&& image) {
  auto* held = new shade::Image(std::move(image));
  const py::capsule owner(held, [](void* p) { delete static_cast<shade::Image*>(p); });
  const auto height = static_cast<py::ssize_t>(held->height);
  const auto width = static_cast<py::ssize_t>(held->width);
  const auto channels = static_cast<py::ssize_t>(held->channels);
  const py::ssize_t row = width * channels * static_cast<py::ssize_t>(sizeof(float));
  float* top = height > 0 ? held->pixel(0, held->height - 1) : held->pixels.data();
  return py::array_t<float>({height, width, channels},
                            {-row, channels * py::ssize_t{sizeof(float)}, py::ssize_t{4}}, top,
                            owner);
}

std::vector<std::string> pass_names(const PassesArg& passes) {
  if (!py::isinstance<py::sequence>(passes) || py::isinstance<py::str>(passes)) {
    throw py::value_error("passes: a sequence of names wanted");
  }
  std::vector<std::string> names;
  for (const py::handle name : passes) names.push_back(py::str(name).cast<std::string>());
  return names;
}

std::array<std::uint32_t, 4> region_of(const RegionArg& region) {
  const auto ids = checked_ids(region, "region");
  if (ids.size() != 4) {
    throw py::value_error("region: (x0, y0, x1, y1) wanted, got " + std::to_string(ids.size()) +
                          " numbers");
  }
  if (ids == std::vector<std::uint32_t>(4, 0)) throw py::value_error("region: is empty");
  return {ids[0], ids[1], ids[2], ids[3]};
}

std::uint32_t size_of(const IntArg& size, const char* name, std::uint32_t highest) {
  return static_cast<std::uint32_t>(checked_int(size, name, 1, highest));
}

/// The picture, rendered without the GIL. `cancel` and `progress` may be empty.
render::Frame rendered(SceneHandle& self, const Camera& camera, render::RenderSettings& settings,
                       const std::optional<ProgressArg>& progress,
                       const std::optional<CancelArg>& cancel) {
  const Tracing tracing(self);
  PythonPoll poll;
  settings.poll = [&](double fraction) {
    return poll([&] {
      if (progress) (*progress)(fraction);
      return !cancel || !py::cast<bool>(py::bool_((*cancel)()));
    });
  };
  render::Frame frame;
  {
    const py::gil_scoped_release no_gil;
    const std::lock_guard one_picture(self.rendering);
    frame = self.renderer.render(camera, settings);
  }
  poll.rethrow();
  return frame;
}

Frame bound_frame(render::Frame&& native, const std::vector<std::string>& names) {
  py::dict passes;
  for (const std::string& name : names) {
    const auto image = native.passes.find(name);
    if (image == native.passes.end() || passes.contains(name)) continue;
    passes[py::str(name)] = image_array(std::move(image->second));
  }
  return {as<PassesDict>(passes), FrameStatistics(std::move(native.statistics)), native.cancelled};
}

Frame render_frame(SceneHandle& self, const CameraArg& camera, const IntArg& width,
                   const IntArg& height, const std::string& shading, const IntArg& samples,
                   const PassesArg& passes, const std::optional<RegionArg>& region,
                   const IntArg& seed, bool transparent, const std::optional<ProgressArg>& progress,
                   const std::optional<CancelArg>& cancel) {
  const std::vector<std::string> names = pass_names(passes);
  render::RenderSettings settings;
  settings.width = size_of(width, "width", render::max_side);
  settings.height = size_of(height, "height", render::max_side);
  settings.shading = render::parse_shading(shading);
  settings.samples = size_of(samples, "samples", render::max_samples);
  settings.passes = {names.begin(), names.end()};
  if (region) settings.region = region_of(*region);
  settings.seed = static_cast<std::uint64_t>(
      checked_int(seed, "seed", 0, std::numeric_limits<std::int64_t>::max()));
  settings.transparent_background = transparent;
  return bound_frame(rendered(self, read_camera(camera), settings, progress, cancel), names);
}

}  // namespace

void bind_frame(py::module_& module) {
  py::class_<Frame>(module, "Frame", "A rendered picture and what it cost.")
      .def_readonly("passes", &Frame::passes,
                    "The passes asked for: (H, W, C) float32, first row on top; `[::-1]` is "
                    "C-contiguous.")
      .def_readonly("statistics", &Frame::statistics,
                    "What it cost; the same object at every access.")
      .def_readonly(
          "cancelled", &Frame::cancelled,
          "True if `cancel` ended it: finished tiles are there, the rest is transparent.");
}

void bind_render(SceneClass& scene) {
  scene.def("render", &render_frame, py::arg("camera"), py::arg("width"), py::arg("height"),
            py::kw_only(), py::arg("shading") = "direct", py::arg("samples") = 1,
            py::arg("passes") = py::make_tuple("combined"), py::arg("region") = py::none(),
            py::arg("seed") = 0, py::arg("transparent") = false, py::arg("progress") = py::none(),
            py::arg("cancel") = py::none(),
            R"(Renders a picture of width by height pixels through a `regraft.Camera`.

shading: clay, occlusion, direct, reflection or cost. samples: rays a pixel; with one it
goes through the pixel's centre. passes: any of combined (premultiplied linear RGBA),
depth (distance from the eye, inf where nothing is), normal (world frame), object_index,
cost (nodes and triangles tested). region: pixels (x0, y0, x1, y1) from the lower left
corner, half open; the passes then have its size. seed: of the samples; equal calls give
equal pictures, whatever the number of threads.
transparent: alpha 0 where nothing is, instead of the world's colour.

progress(fraction) and cancel() -> bool are called on this thread about every 20 ms; after
cancel returned true the frame comes back with `cancelled` set. What they raise, and
Ctrl-C, ends the render. Releases the GIL.

Raises ValueError for a wrong argument, RuntimeError if the scene changed since its last
update.)");
}

}  // namespace regraft::bindings
