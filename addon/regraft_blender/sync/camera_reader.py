"""Blender's cameras and viewports as regraft.Camera's arguments.

The window of a perspective camera lies on the plane one unit before the eye, that of a parallel
one is in world units; shift, sensor fit and pixel aspect are worked into it as Blender does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

CameraArguments = dict[str, Any]
Window = tuple[float, float, float, float]
Matrix = npt.NDArray[np.float64]

PANORAMAS = {
    "EQUIRECTANGULAR": "equirectangular",
    "FISHEYE_EQUIDISTANT": "fisheye_equidistant",
    "FISHEYE_EQUISOLID": "fisheye_equisolid",
}
# Cycles' settings lie on the camera from 5.0 on, before under `camera.cycles`; where that add-on
# is off only the raw values are left, and their defaults are these.
CYCLES_ENUM = ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID", "MIRRORBALL")
CYCLES_DEFAULTS = {
    "panorama_type": "FISHEYE_EQUISOLID",
    "latitude_min": -math.pi / 2,
    "latitude_max": math.pi / 2,
    "longitude_min": -math.pi,
    "longitude_max": math.pi,
    "fisheye_fov": math.pi,
    "fisheye_lens": 10.5,
}


@dataclass(frozen=True)
class Picture:
    """The image a camera fills: pixels, and their width over their height."""

    width: int
    height: int
    pixel_aspect: float = 1.0

    @staticmethod
    def of(render: bpy.types.RenderSettings) -> Picture:
        """The final image's whole frame, border or not."""
        percent = render.resolution_percentage
        width, height = render.resolution_x * percent // 100, render.resolution_y * percent // 100
        return Picture(width, height, render.pixel_aspect_x / render.pixel_aspect_y)

    def is_wide(self) -> bool:
        """True if it is at least as wide as high, pixel aspect included."""
        return self.width * self.pixel_aspect >= self.height


def read_camera(ob: bpy.types.Object, picture: Picture) -> tuple[CameraArguments, str]:
    """Arguments for an evaluated camera object, and a warning or an empty string."""
    camera = ob.data
    matrix = np.array(ob.matrix_world.normalized(), np.float64)
    arguments: CameraArguments = {
        "matrix": matrix,
        "clip_near": camera.clip_start,
        "clip_far": camera.clip_end,
    }
    if camera.type == "PANO":
        more, warning = _panorama(camera, picture)
        return {**arguments, **more}, warning
    kind = "orthographic" if camera.type == "ORTHO" else "perspective"
    return {**arguments, "kind": kind, "window": _window(camera, picture)}, ""


def read_view(view: bpy.types.RegionView3D, clip: tuple[float, float]) -> CameraArguments:
    """Arguments for what a viewport shows. Its projection holds lens, shift, zoom and offset,
    also when it looks through a camera."""
    projection = np.array(view.window_matrix, np.float64)
    matrix = np.linalg.inv(np.array(view.view_matrix, np.float64))
    is_parallel = projection[3, 3] == 1.0
    if is_parallel:
        # A parallel view also shows what lies behind its plane; only the matrix says how far.
        scale, offset = projection[2, 2], projection[2, 3]
        clip = float((offset + 1) / scale), float((offset - 1) / scale)
    return {
        "kind": "orthographic" if is_parallel else "perspective",
        "matrix": matrix,
        "clip_near": clip[0],
        "clip_far": clip[1],
        "window": _window_of(projection, bool(is_parallel)),
    }


def read_panoramic_view(
    ob: bpy.types.Object, picture: Picture, frame: Window
) -> tuple[CameraArguments, str]:
    """Arguments for a viewport that looks through a panoramic camera; `frame` is the viewport's
    outline in units of the camera's image, whose own is (0, 1, 0, 1)."""
    arguments, warning = read_camera(ob, picture)
    left, right, bottom, top = frame
    if "longitude" in arguments:
        arguments["longitude"] = _spread(arguments["longitude"], left, right)
        arguments["latitude"] = _spread(arguments["latitude"], bottom, top)
    else:
        window = arguments["window"]
        arguments["window"] = (
            *_spread((window[0], window[1]), left, right),
            *_spread((window[2], window[3]), bottom, top),
        )
    return arguments, warning


def _spread(span: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """The part (or more) of `span` from share `low` to share `high`."""
    width = span[1] - span[0]
    return span[0] + width * low, span[0] + width * high


def _window_of(projection: Matrix, is_parallel: bool) -> Window:
    """The window of an OpenGL projection matrix (4,4)."""
    sides = []
    for axis in (0, 1):
        scale, offset = projection[axis, axis], projection[axis, 3 if is_parallel else 2]
        centre = -offset / scale if is_parallel else offset / scale
        sides += [centre - 1 / scale, centre + 1 / scale]
    return sides[0], sides[1], sides[2], sides[3]


def _window(camera: bpy.types.Camera, picture: Picture) -> Window:
    """Blender's view plane (as BKE_camera_params_compute_viewplane makes it)."""
    fit = camera.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if picture.is_wide() else "VERTICAL"
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    span = camera.ortho_scale if camera.type == "ORTHO" else sensor / camera.lens
    width, height = float(picture.width), picture.height / picture.pixel_aspect
    factor = width if fit == "HORIZONTAL" else height
    unit = span / factor
    x, y = camera.shift_x * factor, camera.shift_y * factor
    return (
        (x - width / 2) * unit,
        (x + width / 2) * unit,
        (y - height / 2) * unit,
        (y + height / 2) * unit,
    )


def _panorama(camera: bpy.types.Camera, picture: Picture) -> tuple[CameraArguments, str]:
    """Kind and extent of a panoramic camera; kinds we lack become equirectangular, and say so."""
    kind = PANORAMAS.get(str(_cycles(camera, "panorama_type")))
    warning = ""
    if kind is None:
        kind = "equirectangular"
        warning = f"camera '{camera.name}': this kind of panorama is drawn as equirectangular"
    if kind == "equirectangular":
        return {
            "kind": kind,
            "longitude": (_cycles(camera, "longitude_min"), _cycles(camera, "longitude_max")),
            "latitude": (_cycles(camera, "latitude_min"), _cycles(camera, "latitude_max")),
        }, warning
    fov = float(_cycles(camera, "fisheye_fov"))
    if kind == "fisheye_equidistant":
        return {"kind": kind, "fov": fov, "window": (-1.0, 1.0, -1.0, 1.0)}, warning
    return {"kind": kind, "fov": fov, "window": _equisolid_window(camera, picture, fov)}, warning


def _equisolid_window(camera: bpy.types.Camera, picture: Picture, fov: float) -> Window:
    """The sensor in units of the circle that `fov` draws on it: radius 2 f sin(fov / 4)."""
    radius = 2 * float(_cycles(camera, "fisheye_lens")) * math.sin(fov / 4)
    aspect = picture.width * picture.pixel_aspect / picture.height
    is_wide = camera.sensor_fit == "HORIZONTAL" or (
        camera.sensor_fit == "AUTO" and picture.is_wide()
    )
    if camera.sensor_fit == "VERTICAL":
        width, height = camera.sensor_height * aspect, camera.sensor_height
    elif is_wide:
        width, height = camera.sensor_width, camera.sensor_width / aspect
    else:
        width, height = camera.sensor_width * aspect, camera.sensor_width
    return -width / 2 / radius, width / 2 / radius, -height / 2 / radius, height / 2 / radius


def _cycles(camera: bpy.types.Camera, name: str) -> Any:
    """One panorama setting, wherever this version keeps it."""
    holder = camera if hasattr(camera, name) else getattr(camera, "cycles", None)
    if holder is not None and hasattr(holder, name):
        return getattr(holder, name)
    stored = camera.get("cycles") or {}
    value = stored.get(name, CYCLES_DEFAULTS[name])
    if name == "panorama_type" and isinstance(value, int):
        return CYCLES_ENUM[value] if value < len(CYCLES_ENUM) else str(value)
    return value
