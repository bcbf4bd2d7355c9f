"""The parts of a walking robot: shapes modelled round their joints, and the tree they hang in.

The robot faces +Y and is about two metres tall. Slot 0 is the shell, which every robot has in its
own colour, 1 bare metal, 2 rubber, 3 a glowing light.
"""

import math

from shapes import Shape, bevelled, box, cylinder, icosphere, joined, lathe

THIGH, SHIN, ANKLE_HEIGHT, HIP_WIDTH = 0.43, 0.43, 0.12, 0.17
SHELL, METAL, RUBBER, LIGHT = range(4)


def block(x: float, y: float, z: float, width: float = 0.02, slot: int = SHELL) -> Shape:
    """A box with rounded edges."""
    return bevelled(box(x, y, z), width, 3).painted(slot)


def along_x(shape: Shape) -> Shape:
    """Lays a lathe along X, centred lengthwise by its own profile."""
    return shape.turned(y=math.pi / 2)


def drum(radius: float, length: float, slot: int = METAL) -> Shape:
    """A joint's axle across the body, with rounded rims."""
    r, h, e = radius, length / 2, radius * 0.12
    return along_x(lathe([(r - e, -h), (r, -h + e), (r, h - e), (r - e, h)], 28)).painted(slot)


def limb(top: float, bottom: float, length: float, slot: int = SHELL) -> Shape:
    """A tapered sleeve hanging down from the joint."""
    rim = 0.02
    profile = [
        (bottom - rim, -length + 0.06),
        (bottom, -length + 0.06 + rim),
        ((top + bottom) / 2 * 1.08, -length / 2),
        (top, -0.06 - rim),
        (top - rim, -0.06),
    ]
    core = cylinder(bottom * 0.55, length, 16).moved(z=-length).painted(METAL)
    return lathe(profile, 28).painted(slot) + core


def ball(radius: float, slot: int) -> Shape:
    return icosphere(radius, 3).painted(slot)


def shapes_by_name() -> dict[str, Shape]:
    """Every part's shape; left and right use the same one."""
    return _body() | _head() | _arm() | _leg()


def _body() -> dict[str, Shape]:
    ring = lathe([(0.10, 0.0), (0.10, 0.025), (0.075, 0.04), (0.075, 0.0)][:3], 28)
    folds = joined([ring.moved(z=0.045 * k) for k in range(4)])
    vents = joined([box(0.16, 0.012, 0.012).moved(z=0.03 * k) for k in range(5)])
    hub = lathe([(0.052, 0.0), (0.052, 0.02), (0.044, 0.028)], 24).turned(x=-math.pi / 2)
    teeth = [box(0.016, 0.018, 0.03).moved(z=0.058).turned(y=k * math.pi / 4) for k in range(8)]
    return {
        "Hips": block(0.34, 0.22, 0.16, 0.04) + drum(0.07, 0.40),
        "Waist": folds.painted(RUBBER),
        "Chest": block(0.50, 0.32, 0.46, 0.07).moved(z=0.27)
        + block(0.40, 0.27, 0.1, 0.03).moved(z=0.03),
        "Panel": block(0.24, 0.03, 0.20, 0.012, METAL)
        + vents.moved(y=0.016, z=-0.06).painted(RUBBER),
        "Dial": (hub + joined(teeth).moved(y=0.01)).painted(METAL),
        "Lamp": ball(0.028, LIGHT),
        "Backpack": block(0.34, 0.14, 0.34, 0.04, METAL),
        "Pipe": lathe([(0.035, 0.0), (0.035, 0.2), (0.045, 0.21), (0.045, 0.25)], 20).painted(
            METAL
        ),
    }


def _head() -> dict[str, Shape]:
    dome = [
        (0.15, 0.0),
        (0.165, 0.02),
        (0.165, 0.13),
        (0.15, 0.19),
        (0.11, 0.235),
        (0.05, 0.255),
        (0.0, 0.26),
    ]
    return {
        "Neck": lathe([(0.07, 0.0), (0.055, 0.02), (0.055, 0.1), (0.08, 0.12)], 24).painted(RUBBER),
        "Head": lathe(dome, 36),
        "Visor": block(0.27, 0.05, 0.11, 0.02, RUBBER),
        "Eye": lathe([(0.036, 0.0), (0.036, 0.02), (0.026, 0.03)], 24)
        .turned(x=-math.pi / 2)
        .painted(LIGHT),
        "Ear": drum(0.05, 0.05),
        "Antenna": lathe([(0.012, 0.0), (0.012, 0.03), (0.006, 0.05), (0.004, 0.16)], 12).painted(
            METAL
        ),
        "Antenna tip": ball(0.02, LIGHT),
    }


def _arm() -> dict[str, Shape]:
    palm = block(0.075, 0.11, 0.10, 0.018, METAL).moved(z=-0.05)
    return {
        "Shoulder": ball(0.105, METAL),
        "Upper arm": limb(0.07, 0.06, 0.32),
        "Elbow": drum(0.062, 0.13),
        "Forearm": limb(0.062, 0.072, 0.28),
        "Wrist": lathe([(0.045, -0.05), (0.05, -0.03), (0.05, 0.0)], 20).painted(RUBBER),
        "Hand": palm,
        "Finger": block(0.028, 0.028, 0.075, 0.008, METAL).moved(z=-0.03),
        "Fingertip": block(0.024, 0.024, 0.06, 0.008, RUBBER).moved(z=-0.024),
    }


def _leg() -> dict[str, Shape]:
    sole = block(0.15, 0.25, 0.035, 0.012, RUBBER).moved(y=0.02, z=-ANKLE_HEIGHT + 0.0175)
    upper = block(0.14, 0.22, 0.07, 0.025).moved(y=0.02, z=-0.062)
    return {
        "Thigh": limb(0.085, 0.075, THIGH) + ball(0.09, METAL),
        "Knee": drum(0.072, 0.15) + block(0.08, 0.05, 0.1, 0.02).moved(y=0.07),
        "Shin": limb(0.075, 0.06, SHIN),
        "Ankle": drum(0.05, 0.12),
        "Foot": sole + upper,
        "Toe": block(0.15, 0.1, 0.06, 0.02, RUBBER).moved(y=0.04, z=0.0),
    }


# name, parent, joint's place in the parent's frame; * stands for a left (−x) and a right part
TREE: list[tuple[str, str, tuple[float, float, float]]] = [
    ("Hips", "", (0, 0, 0)),
    ("Waist", "Hips", (0, 0, 0.07)),
    ("Chest", "Waist", (0, 0, 0.17)),
    ("Panel", "Chest", (0, 0.16, 0.32)),
    ("Dial", "Chest", (0, 0.155, 0.13)),
    ("Lamp*", "Chest", (0.19, 0.165, 0.40)),
    ("Backpack", "Chest", (0, -0.2, 0.28)),
    ("Pipe*", "Backpack", (0.1, -0.02, 0.15)),
    ("Neck", "Chest", (0, 0, 0.49)),
    ("Head", "Neck", (0, 0, 0.11)),
    ("Visor", "Head", (0, 0.145, 0.12)),
    ("Eye*", "Visor", (0.065, 0.02, 0.0)),
    ("Ear*", "Head", (0.175, 0, 0.1)),
    ("Antenna*", "Ear*", (0.01, 0, 0.045)),
    ("Antenna tip*", "Antenna*", (0, 0, 0.17)),
    ("Shoulder*", "Chest", (0.32, 0, 0.41)),
    ("Upper arm*", "Shoulder*", (0.03, 0, -0.03)),
    ("Elbow*", "Upper arm*", (0, 0, -0.33)),
    ("Forearm*", "Elbow*", (0, 0, 0)),
    ("Wrist*", "Forearm*", (0, 0, -0.26)),
    ("Hand*", "Wrist*", (0, 0, -0.04)),
    ("Thumb*", "Hand*", (-0.03, 0.03, -0.03)),
    ("Thumb tip*", "Thumb*", (0, 0, -0.062)),
    ("Index*", "Hand*", (0.012, 0.035, -0.1)),
    ("Index tip*", "Index*", (0, 0, -0.062)),
    ("Little*", "Hand*", (0.012, -0.035, -0.1)),
    ("Little tip*", "Little*", (0, 0, -0.062)),
    ("Thigh*", "Hips", (HIP_WIDTH, 0, -0.05)),
    ("Knee*", "Thigh*", (0, 0, -THIGH)),
    ("Shin*", "Knee*", (0, 0, 0)),
    ("Ankle*", "Shin*", (0, 0, -SHIN)),
    ("Foot*", "Ankle*", (0, 0, 0)),
    ("Toe*", "Foot*", (0, 0.16, -ANKLE_HEIGHT + 0.031)),
]
_FINGERS = ("Thumb", "Index", "Little")
SHAPE_OF = dict.fromkeys(_FINGERS, "Finger") | {f"{f} tip": "Fingertip" for f in _FINGERS}
