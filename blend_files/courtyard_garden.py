"""What stands and grows in the courtyard: setts, pots, plants, benches, the fountain; in metres.

Material slots are those of `courtyard_parts.PALETTE`.
"""

import math

import numpy as np
from courtyard_parts import SLOT, block, turned
from numpy.typing import NDArray
from shapes import Shape, icosphere, joined

Array = NDArray[np.float64]
Triple = tuple[float, float, float]


def garden_parts(rng: np.random.Generator) -> dict[str, Shape]:
    """Setts, pots, plants, fountain, bench."""
    pot = [
        (0.2, 0.0),
        (0.22, 0.03),
        (0.3, 0.3),
        (0.33, 0.46),
        (0.37, 0.48),
        (0.37, 0.55),
        (0.33, 0.56),
        (0.31, 0.5),
        (0.0, 0.48),
    ]
    bench = [block(1.6, 0.13, 0.05, "Wood").moved(y=y, z=0.45) for y in (-0.16, 0.0, 0.16)]
    feet = [block(0.16, 0.48, 0.43, "Stone", 0.03).moved(x=x, z=0.215) for x in (-0.6, 0.6)]
    crown = foliage(rng, 340, 0.62, 0.15).moved(z=1.65)
    fruit = [
        icosphere(0.05, 2).moved(*(0.62 * p / np.linalg.norm(p))).moved(z=1.65)
        for p in rng.normal(0, 1, (22, 3))
    ]
    curb = block(2.1, 0.7, 0.24, "Stone", 0.03).moved(z=0.1)
    trunk = turned([(0.05, 0.0), (0.035, 0.6), (0.03, 1.3), (0.0, 1.6)], 12, "Wood")
    return {
        **{f"Paving {k}": paving(rng) for k in range(4)},
        "Pot": turned(pot, 40, "Terracotta"),
        "Shrub": foliage(rng, 130, 0.30, 0.13),
        "Blooms": blooms(rng, 34, 0.36),
        "Trailer": foliage(rng, 60, 0.16, 0.10).scaled(2.2, 0.8, 0.9),
        "Trunk": trunk,
        "Crown": crown,
        "Fruit": joined(fruit).painted(SLOT["Fruit"]),
        "Bench": joined([*bench, *feet]),
        "Hedge": foliage(rng, 640, 0.5, 0.15, (2.1, 0.6, 0.6)).moved(z=0.42) + curb,
        **fountain_parts(),
    }


def paving(rng: np.random.Generator, count: int = 4, size: float = 1.35) -> Shape:
    """A patch of setts of three shades, each a little off its neighbours' height."""
    step = size / count
    middles = (np.arange(count) + 0.5) * step - size / 2
    shades = "Sett", "Dark sett", "Warm sett"
    setts = [block(step * 0.92, step * 0.92, 0.1, shade, 0.025) for shade in shades]
    return joined(
        [
            setts[rng.integers(3)]
            .turned(z=rng.normal(0, 0.03))
            .moved(x, y, rng.uniform(-0.06, -0.04))
            for x in middles
            for y in middles
        ]
    )


def foliage(
    rng: np.random.Generator, leaves: int, radius: float, length: float, stretch: Triple = (1, 1, 1)
) -> Shape:
    """Bent pointed leaves filling a ball, or an ellipsoid if stretched."""
    wide, rows = (
        length * 0.21,
        ((0.0, 0.1, 0.0), (0.35, 1.0, 0.03), (0.7, 0.75, 0.02), (1.0, 0.05, -0.04)),
    )
    points = [
        (side * width * wide, at * length, lift) for at, width, lift in rows for side in (-1, 1)
    ]
    leaf = Shape(np.array(points), [[k, k + 1, k + 3, k + 2] for k in (0, 2, 4)])
    places = scattered_in_ball(rng, leaves, radius) * np.array(stretch)
    turns = rng.uniform(-math.pi, math.pi, (leaves, 3))
    placed = [leaf.turned(*turn).moved(*at) for turn, at in zip(turns, places, strict=True)]
    return joined(placed).painted(SLOT["Leaf"])


def scattered_in_ball(
    rng: np.random.Generator, count: int, radius: float, inner: float = 0.3
) -> Array:
    """Points (count, 3) in a ball, crowding towards its surface."""
    places = rng.normal(0, 1, (count, 3))
    reach = radius * rng.uniform(inner, 1, (count, 1)) ** 0.4
    return np.asarray(places * reach / np.linalg.norm(places, axis=1, keepdims=True))


def blooms(rng: np.random.Generator, count: int, radius: float) -> Shape:
    """Flowers of six petals with a bright heart, turned outwards on the upper side of a ball."""
    petal = Shape(
        np.array(
            [
                (-0.006, 0, 0),
                (0.006, 0, 0),
                (-0.02, 0.03, 0.012),
                (0.02, 0.03, 0.012),
                (-0.01, 0.05, 0.008),
                (0.01, 0.05, 0.008),
            ]
        ),
        [[0, 1, 3, 2], [2, 3, 5, 4]],
    )
    petals = joined([petal.turned(z=k * math.pi / 3) for k in range(6)]).painted(SLOT["Bloom"])
    flower = petals + icosphere(0.012, 1).moved(z=0.008).painted(SLOT["Fruit"])
    placed = []
    for place in scattered_in_ball(rng, count, radius, 0.9):
        place[2] = abs(place[2])
        tilt, around = math.acos(place[2] / np.linalg.norm(place)), math.atan2(place[1], place[0])
        placed.append(flower.turned(y=tilt).turned(z=around).moved(*place))
    return joined(placed)


def fountain_parts() -> dict[str, Shape]:
    """Steps, basin, stem with two bowls, water."""
    rim = [
        (1.9, 0.0),
        (1.95, 0.05),
        (1.9, 0.42),
        (1.98, 0.46),
        (2.02, 0.52),
        (1.98, 0.58),
        (1.78, 0.58),
        (1.74, 0.52),
        (1.74, 0.1),
        (0.0, 0.1),
    ]
    stem = [
        (0.5, 0.0),
        (0.5, 0.14),
        (0.3, 0.2),
        (0.2, 0.4),
        (0.24, 0.6),
        (0.16, 0.8),
        (0.15, 1.1),
        (0.24, 1.16),
        (0.7, 1.34),
        (0.98, 1.52),
        (1.0, 1.58),
        (0.94, 1.6),
        (0.66, 1.46),
        (0.2, 1.42),
    ]
    top = [
        (0.2, 0.0),
        (0.14, 0.05),
        (0.1, 0.3),
        (0.16, 0.45),
        (0.42, 0.56),
        (0.5, 0.66),
        (0.46, 0.68),
        (0.2, 0.6),
        (0.08, 0.62),
        (0.1, 0.72),
        (0.14, 0.8),
        (0.1, 0.9),
        (0.0, 0.96),
    ]
    return {
        "Fountain steps": turned(
            [(2.9, 0.0), (2.9, 0.13), (2.86, 0.15), (2.4, 0.15), (2.4, 0.29), (2.36, 0.31)],
            8,
            "Stone",
        ),
        "Basin": turned(rim, 96, "Stone"),
        "Stem": turned(stem, 72, "Stone"),
        "Upper bowl": turned(top, 64, "Stone"),
        "Water": turned([(1.73, 0.0), (0.0, 0.004)], 64, "Water"),
        "Jet": turned([(0.02, 0.0), (0.012, 0.35), (0.03, 0.42), (0.0, 0.47)], 16, "Water"),
    }
