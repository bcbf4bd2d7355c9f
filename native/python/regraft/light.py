"""The light the scene is given: a frozen value, checked once, read by attribute from C++."""

from __future__ import annotations

import math
from dataclasses import dataclass

from regraft import checks

KINDS = ("point", "spot", "sun", "area")


@dataclass(frozen=True)
class Light:
    """A light in the world frame; lengths in metres, angles in radians.

    `energy` is as in Blender: watt, for a sun W/m². `color` is linear RGB. `direction` is where
    the light looks (kept at unit length; a point light ignores it). `radius`: of the sphere of a
    point or spot light; for a sun, half the angle it is seen under. `spot_angle` is the full
    cone, `spot_blend` in [0, 1] the soft share of it. An area light spans `size` (full widths)
    along `axis_x` and `axis_y`.

    Raises ValueError naming the attribute that is wrong.
    """

    kind: str
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    direction: tuple[float, ...] = (0.0, 0.0, -1.0)
    color: tuple[float, ...] = (1.0, 1.0, 1.0)
    energy: float = 1.0
    radius: float = 0.0
    spot_angle: float = math.pi / 4
    spot_blend: float = 0.15
    axis_x: tuple[float, ...] = (1.0, 0.0, 0.0)
    axis_y: tuple[float, ...] = (0.0, 1.0, 0.0)
    size: tuple[float, ...] = (1.0, 1.0)
    cast_shadow: bool = True

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"Light.kind: {self.kind!r} is none of {', '.join(KINDS)}")
        plain: dict[str, object] = {
            "position": checks.floats("Light", "position", self.position, 3),
            "color": checks.floats("Light", "color", self.color, 3),
            "energy": checks.floats("Light", "energy", (self.energy,), 1)[0],
            "radius": checks.number("Light", "radius", self.radius, 0.0),
            "spot_angle": checks.number("Light", "spot_angle", self.spot_angle, 0.0, math.tau),
            "spot_blend": checks.number("Light", "spot_blend", self.spot_blend, 0.0, 1.0),
            "size": checks.floats("Light", "size", self.size, 2),
            "cast_shadow": bool(self.cast_shadow),
        }
        for name in ("direction", "axis_x", "axis_y"):
            plain[name] = checks.unit_vector("Light", name, getattr(self, name))
        for name, value in plain.items():
            object.__setattr__(self, name, value)
