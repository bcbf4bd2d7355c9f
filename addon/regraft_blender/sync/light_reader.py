"""Blender's lights as the library takes them."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from .. import compat

# Constructor arguments of regraft.Light that do not depend on where the light stands.
LightSettings = dict[str, Any]


def read_light(light: bpy.types.Light) -> LightSettings:
    """Kind, colour and size of an evaluated light; energy in watt, of a sun in W/m²."""
    settings: LightSettings = {
        "kind": light.type.lower(),
        "color": _colour(light),
        "energy": light.energy * 2.0 ** getattr(light, "exposure", 0.0),
        "cast_shadow": light.use_shadow,
    }
    if light.type == "SUN":
        settings["radius"] = light.angle / 2
    elif light.type == "AREA":
        is_oblong = light.shape in {"RECTANGLE", "ELLIPSE"}
        settings["energy"] *= compat.AREA_LIGHT_POWER
        settings["size"] = (light.size, light.size_y if is_oblong else light.size)
    else:
        settings["radius"] = light.shadow_soft_size
    if light.type == "SPOT":
        settings["spot_angle"] = light.spot_size
        settings["spot_blend"] = light.spot_blend
    return settings


def placed(settings: LightSettings, transform: npt.NDArray[np.float64]) -> dict[str, Any]:
    """Arguments of regraft.Light for a light at `transform` (4,4), which looks along its -Z."""
    axes = transform[:3, :3].T
    lengths = np.linalg.norm(axes, axis=1)
    units = np.where(lengths[:, None] > 0, axes / np.maximum(lengths, 1e-30)[:, None], np.eye(3))
    place = {
        "position": tuple(transform[:3, 3].tolist()),
        "direction": tuple((-units[2]).tolist()),
        "axis_x": tuple(units[0].tolist()),
        "axis_y": tuple(units[1].tolist()),
    }
    if "size" in settings:
        width, height = settings["size"]
        place["size"] = (width * float(lengths[0]), height * float(lengths[1]))
    return {**settings, **place}


def _colour(light: bpy.types.Light) -> tuple[float, float, float]:
    colour = tuple(light.color)
    if getattr(light, "use_temperature", False):
        warmth = tuple(light.temperature_color)
        colour = tuple(a * b for a, b in zip(colour, warmth, strict=True))
    return colour[0], colour[1], colour[2]
