"""The building parts of a Mediterranean courtyard, each modelled once round its own origin, in
metres.

A wing's front runs along X and faces −Y; parts of a bay are centred on x = 0. Material slots are
those of `PALETTE`.
"""

import math

import numpy as np
from shapes import Shape, bevelled, box, joined, lathe, prism

BAY, GROUND_FLOOR, UPPER_FLOOR, ARCADE = 2.7, 3.9, 3.5, 3.2
SPRING, ARCH_RADIUS = 2.35, 1.08
COURSES, TILE_LENGTH, PITCH = 13, 0.40, math.radians(24)

PALETTE = {
    "Plaster": (0.72, 0.50, 0.28),
    "Stone": (0.66, 0.60, 0.50),
    "Terracotta": (0.55, 0.20, 0.09),
    "Shutter": (0.07, 0.27, 0.25),
    "Wood": (0.25, 0.13, 0.06),
    "Glass": (0.04, 0.06, 0.08),
    "Leaf": (0.10, 0.24, 0.05),
    "Bloom": (0.72, 0.06, 0.14),
    "Iron": (0.05, 0.05, 0.06),
    "Water": (0.10, 0.32, 0.38),
    "Sett": (0.36, 0.32, 0.29),
    "Dark sett": (0.25, 0.23, 0.22),
    "Warm sett": (0.44, 0.35, 0.28),
    "Fruit": (0.90, 0.40, 0.03),
    "Lamplight": (1.00, 0.75, 0.35),
}
SLOT = {name: number for number, name in enumerate(PALETTE)}


def block(x: float, y: float, z: float, paint: str, round_by: float = 0.012) -> Shape:
    return bevelled(box(x, y, z), round_by).painted(SLOT[paint])


def turned(profile: list[tuple[float, float]], segments: int, paint: str) -> Shape:
    return lathe(profile, segments).painted(SLOT[paint])


def column_parts() -> dict[str, Shape]:
    """Base, fluted shaft and capital of an arcade column, standing on the floor."""
    base = [
        (0.24, 0.12),
        (0.26, 0.14),
        (0.26, 0.19),
        (0.21, 0.22),
        (0.20, 0.26),
        (0.23, 0.29),
        (0.23, 0.33),
        (0.18, 0.36),
    ]
    shaft = [(0.17 - 0.03 * t**1.6, 0.36 + 1.56 * t) for t in np.linspace(0, 1, 13)]
    bell = [
        (0.15, 1.92),
        (0.17, 1.94),
        (0.15, 1.96),
        (0.15, 2.00),
        (0.17, 2.08),
        (0.22, 2.16),
        (0.27, 2.20),
    ]
    fluted = turned(shaft, 48, "Stone")
    groove = 1 - 0.06 * (np.arange(48) % 2)
    around = np.tile(groove, len(fluted.vertices) // 48)
    fluted.vertices[:, :2] *= around[:, None]
    leaves = [
        block(0.07, 0.02, 0.16, "Stone", 0.008)
        .turned(x=0.35)
        .moved(0, -0.2, 2.08)
        .turned(z=k * math.pi / 4)
        for k in range(8)
    ]
    return {
        "Column base": block(0.56, 0.56, 0.12, "Stone").moved(z=0.06) + turned(base, 40, "Stone"),
        "Column shaft": fluted,
        "Capital": turned(bell, 40, "Stone")
        + block(0.54, 0.54, 0.15, "Stone", 0.02).moved(z=2.275)
        + joined(leaves),
    }


def arch_parts(stones: int = 13) -> dict[str, Shape]:
    """The wall over an arcade arch, and one of the stones of its ring (at the crown)."""
    angles = np.linspace(math.pi, 0, 25)
    arc = [(ARCH_RADIUS * math.cos(a), SPRING + ARCH_RADIUS * math.sin(a)) for a in angles]
    half = BAY / 2
    # Two halves: an outline round the whole arch would leave long thin triangles.
    left = [(-half, GROUND_FLOOR), (-half, SPRING), *arc[:13], (0.0, GROUND_FLOOR)]
    right = [(0.0, GROUND_FLOOR), *arc[12:], (half, SPRING), (half, GROUND_FLOOR)]
    wall = joined([prism(outline, 0.42).moved(y=-0.21) for outline in (left, right)])
    half_turn = math.pi / stones / 2 * 0.94
    inner, outer = ARCH_RADIUS - 0.02, ARCH_RADIUS + 0.27
    corners = [
        (r * math.sin(s), r * math.cos(s))
        for r, s in (
            (inner, -half_turn),
            (inner, half_turn),
            (outer, half_turn),
            (outer, -half_turn),
        )
    ]
    stone = bevelled(prism(corners, 0.5).moved(y=-0.25), 0.018).painted(SLOT["Stone"])
    return {"Arch wall": wall.painted(SLOT["Plaster"]), "Arch stone": stone}


def wall_parts() -> dict[str, Shape]:
    """Plain walls and floors of a bay, and the upper wall round its window."""
    side, sill, head = (BAY - 1.1) / 2, 0.95, UPPER_FLOOR - 2.65
    upper = [
        box(side, 0.42, UPPER_FLOOR).moved(-(1.1 + side) / 2, 0, UPPER_FLOOR / 2),
        box(side, 0.42, UPPER_FLOOR).moved((1.1 + side) / 2, 0, UPPER_FLOOR / 2),
        box(1.1, 0.42, sill).moved(z=sill / 2),
        box(1.1, 0.42, head).moved(z=UPPER_FLOOR - head / 2),
    ]
    dentils = [
        block(0.11, 0.16, 0.12, "Stone").moved(x=(k - 5.5) * BAY / 12, y=-0.28, z=-0.12)
        for k in range(12)
    ]
    return {
        "Upper wall": joined(upper).painted(SLOT["Plaster"]),
        "Back wall": box(BAY, 0.3, GROUND_FLOOR).moved(z=GROUND_FLOOR / 2).painted(SLOT["Plaster"]),
        "Arcade floor": joined(
            [
                block(0.88, 1.05, 0.12, "Terracotta").moved(x * 0.9, y * 1.07, 0.0)
                for x in (-1, 0, 1)
                for y in (-1, 0, 1)
            ]
        ),
        "Ceiling": joined([block(BAY, 0.16, 0.2, "Wood").moved(y=y) for y in (-1, 0, 1)])
        + box(BAY, ARCADE, 0.06).moved(z=0.13).painted(SLOT["Plaster"]),
        "Cornice": joined([block(BAY, 0.72, 0.14, "Stone", 0.03).moved(y=-0.1, z=0.0), *dentils]),
    }


def window_parts() -> dict[str, Shape]:
    """A window's frame, sash, glass, slatted shutter, sill, knob and flower box; origin at the
    sill's middle.
    """
    bars = [block(0.05, 0.05, 1.6, "Wood").moved(x, 0, 0.8) for x in (-0.235, 0.0, 0.235)]
    rails = [block(0.47, 0.045, 0.05, "Wood").moved(z=z) for z in (0.03, 0.55, 1.06, 1.57)]
    slats = [
        block(0.40, 0.03, 0.07, "Shutter", 0.006).turned(x=0.6).moved(z=0.14 + 0.088 * k)
        for k in range(16)
    ]
    stiles = [block(0.06, 0.06, 1.66, "Shutter").moved(x, 0, 0.8) for x in (-0.23, 0.23)]
    rungs = [block(0.5, 0.05, 0.07, "Shutter").moved(z=z) for z in (0.02, 1.6)]
    jambs = [block(0.14, 0.5, 1.85, "Stone", 0.02).moved(x, 0, 0.86) for x in (-0.6, 0.6)]
    lintel = block(1.5, 0.54, 0.2, "Stone", 0.03).moved(z=1.85)
    return {
        "Window frame": joined([*jambs, lintel]),
        "Sash": joined([*bars, *rails]),
        "Glass": box(0.44, 0.012, 1.56).moved(z=0.8).painted(SLOT["Glass"]),
        "Shutter": joined([*stiles, *rungs, *slats]).moved(x=0.26),
        "Sill": block(1.6, 0.62, 0.1, "Stone", 0.025).moved(y=-0.05, z=-0.05),
        "Knob": turned(
            [
                (0.008, 0.0),
                (0.008, 0.03),
                (0.022, 0.04),
                (0.026, 0.055),
                (0.016, 0.07),
                (0.0, 0.074),
            ],
            20,
            "Iron",
        ).turned(x=math.pi / 2),
        "Flower box": joined(
            [
                block(1.1, 0.26, 0.22, "Terracotta", 0.03),
                block(1.0, 0.18, 0.04, "Wood").moved(z=0.1),
            ]
        ),
    }


def gallery_parts() -> dict[str, Shape]:
    """Balustrade of the upper floor, its slab and brackets, a door, a hanging lantern."""
    belly = [
        (0.075, 0.0),
        (0.075, 0.05),
        (0.045, 0.07),
        (0.04, 0.1),
        (0.06, 0.16),
        (0.085, 0.25),
        (0.08, 0.33),
        (0.05, 0.45),
        (0.04, 0.55),
        (0.055, 0.58),
        (0.055, 0.61),
        (0.075, 0.63),
        (0.075, 0.68),
    ]
    cage = [
        block(0.02, 0.02, 0.34, "Iron", 0.004).moved(0.1, 0, 0.17).turned(z=k * math.pi / 3)
        for k in range(6)
    ]
    roof = turned(
        [(0.15, 0.34), (0.15, 0.36), (0.05, 0.46), (0.02, 0.5), (0.008, 0.95)], 24, "Iron"
    )
    boards = [block(0.14, 0.07, 2.2, "Wood").moved(x * 0.145, 0, 1.1) for x in (-1, 0, 1)]
    iron = [block(0.42, 0.09, 0.06, "Iron").moved(z=z) for z in (0.35, 1.85)]
    corbel = [(0.0, 0.0), (0.0, 0.42), (-0.62, 0.42), (-0.62, 0.3), (-0.4, 0.26), (-0.16, 0.16)]
    return {
        "Baluster": turned(belly, 28, "Stone"),
        "Hand rail": block(BAY, 0.2, 0.12, "Stone", 0.03),
        "Gallery slab": block(BAY, 0.9, 0.14, "Stone", 0.03),
        "Bracket": bevelled(prism(corbel[::-1], 0.22), 0.02)
        .painted(SLOT["Stone"])
        .moved(y=-0.11)
        .turned(z=math.pi / 2),
        "Door leaf": joined([*boards, *iron]).moved(x=0.22),
        "Door frame": joined(
            [block(0.16, 0.4, 2.4, "Stone", 0.02).moved(x, 0, 1.2) for x in (-0.54, 0.54)]
        )
        + block(1.4, 0.44, 0.22, "Stone", 0.03).moved(z=2.45),
        "Lantern": joined(
            [*cage, roof, turned([(0.12, 0.0), (0.13, 0.02), (0.12, 0.03)], 24, "Iron")]
        ),
        "Flame": turned([(0.03, 0.05), (0.045, 0.1), (0.03, 0.2), (0.0, 0.27)], 16, "Lamplight"),
    }


def roof_parts(tiles: int = 12) -> dict[str, Shape]:
    """One course of half-round tiles across a bay; overlapping courses lie TILE_LENGTH · 0.9 apart
    along Y.
    """
    angles = np.linspace(math.pi, 0, 8)
    outer = [(0.118 * math.cos(a), 0.105 * math.sin(a)) for a in angles]
    inner = [(0.098 * math.cos(a), 0.085 * math.sin(a)) for a in angles]
    cover = prism(inner + outer[::-1], TILE_LENGTH).turned(x=-0.06)
    row = joined([cover.moved(x=(k - (tiles - 1) / 2) * BAY / tiles) for k in range(tiles)])
    bed = box(BAY, TILE_LENGTH, 0.03).moved(y=TILE_LENGTH / 2, z=-0.005)
    return {"Tile course": (row + bed).painted(SLOT["Terracotta"])}


def tower_parts() -> dict[str, Shape]:
    """A corner tower's walls and its tiled tent roof."""
    size = 3.9
    walls = block(size, size, 9.2, "Plaster", 0.03).moved(z=4.6)
    bands = [
        block(size + 0.12, size + 0.12, 0.22, "Stone", 0.04).moved(z=z)
        for z in (0.15, 3.95, 7.4, 9.2)
    ]
    steps = [
        bevelled(
            prism([(-r, 0.0), (r, 0.0), (r - 0.13, 0.17), (-r + 0.13, 0.17)], 2 * r).moved(y=-r),
            0.02,
        ).moved(z=0.14 * k)
        for k, r in enumerate(np.linspace(2.3, 0.2, 18))
    ]
    finial = turned(
        [(0.06, 0.0), (0.14, 0.1), (0.16, 0.22), (0.08, 0.36), (0.02, 0.5), (0.0, 0.9)], 24, "Iron"
    ).moved(z=2.5)
    return {
        "Tower": joined([walls, *bands]),
        "Tower roof": joined(steps).painted(SLOT["Terracotta"]) + finial,
    }


def building_parts() -> dict[str, Shape]:
    """Every part of the building by name."""
    return (
        column_parts()
        | arch_parts()
        | wall_parts()
        | window_parts()
        | gallery_parts()
        | roof_parts()
        | tower_parts()
    )
