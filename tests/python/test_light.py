"""Light: plain values in, checked values out."""

from __future__ import annotations

import dataclasses
import math

import pytest

from regraft import Light


def test_directions_are_kept_at_unit_length() -> None:
    light = Light("area", direction=(0, 0, -3), axis_x=(2, 0, 0), axis_y=(0, 0.5, 0))
    assert light.direction == (0, 0, -1)
    assert (light.axis_x, light.axis_y) == ((1, 0, 0), (0, 1, 0))


def test_values_become_plain_floats() -> None:
    light = Light("point", position=[1, 2, 3], energy=5)  # type: ignore[arg-type]
    assert light.position == (1.0, 2.0, 3.0)
    assert all(type(x) is float for x in (*light.position, light.energy))


def test_a_light_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Light("sun").energy = 2.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"kind": "lamp"}, "kind"),
        ({"position": (0, 0)}, "position"),
        ({"position": 1.0}, "position"),
        ({"direction": (0, 0, 0)}, "direction"),
        ({"color": (math.nan, 0, 0)}, "color"),
        ({"energy": math.inf}, "energy"),
        ({"radius": -1}, "radius"),
        ({"spot_angle": 7}, "spot_angle"),
        ({"spot_blend": 1.5}, "spot_blend"),
        ({"size": (1,)}, "size"),
        ({"axis_y": (0, math.nan, 0)}, "axis_y"),
    ],
)
def test_a_wrong_value_is_refused_by_name(values: dict[str, object], named: str) -> None:
    with pytest.raises(ValueError, match=rf"Light\.{named}"):
        Light(**{"kind": "spot", **values})  # type: ignore[arg-type]
