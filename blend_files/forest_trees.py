"""What grows in the forest: low-polygon trees, bushes, grass and stones, standing on the origin, in
metres.

Material slots are those of `PALETTE`.
"""

import math

import numpy as np
from shapes import Shape, icosphere, joined, lathe

PALETTE = {
    "Bark": (0.17, 0.10, 0.06),
    "Birch bark": (0.70, 0.68, 0.62),
    "Dark needles": (0.035, 0.13, 0.06),
    "Needles": (0.06, 0.20, 0.08),
    "Leaves": (0.20, 0.34, 0.05),
    "Bright leaves": (0.42, 0.46, 0.07),
    "Autumn leaves": (0.62, 0.27, 0.04),
    "Moss": (0.22, 0.28, 0.08),
    "Stone": (0.33, 0.32, 0.30),
}
SLOT = {name: number for number, name in enumerate(PALETTE)}


def trunk(radius: float, height: float, paint: str = "Bark") -> Shape:
    return lathe([(radius * 1.5, -0.4), (radius, 0.35), (radius * 0.35, height)], 8).painted(
        SLOT[paint]
    )


def skirt(radius: float, height: float, points: int, rng: np.random.Generator) -> Shape:
    """One tier of a conifer: a drooping star, closed below."""
    shape = lathe([(radius, 0.0), (0.0, height)], 2 * points)
    ragged = np.where(np.arange(2 * points) % 2, 0.72, 1.0) * rng.uniform(0.88, 1.12, 2 * points)
    shape.vertices[: 2 * points, :2] *= ragged[:, None]
    shape.vertices[: 2 * points, 2] -= (ragged - 0.72) * radius * 0.35
    return shape.turned(z=rng.uniform(0, 6))


def pine(rng: np.random.Generator, height: float, spread: float, tiers: int) -> Shape:
    parts = [trunk(height * 0.022, height * 0.8)]
    for k in range(tiers):
        t = k / tiers
        tier = skirt(spread * (1 - t) ** 0.85 + 0.12, height / tiers * 1.75, 9, rng)
        paint = "Needles" if k % 2 else "Dark needles"
        parts.append(tier.moved(z=height * (0.13 + 0.8 * t)).painted(SLOT[paint]))
    return joined(parts)


def clump(rng: np.random.Generator, radius: float, paint: str, flat: float = 0.8) -> Shape:
    """A lump of leaves: a geodesic ball with dented vertices."""
    ball = icosphere(radius, 2)
    ball.vertices *= rng.uniform(0.82, 1.14, (len(ball.vertices), 1))
    return ball.scaled(1, 1, flat).turned(z=rng.uniform(0, 6)).painted(SLOT[paint])


def leafy(
    rng: np.random.Generator, height: float, spread: float, paints: tuple[str, ...], bark: str
) -> Shape:
    """A broad-leaved tree: a crown of clumps round the top of its trunk."""
    parts = [trunk(height * 0.03, height * 0.75, bark)]
    for k in range(5):
        around, reach = k * 2.4, spread * (0.0 if k == 0 else 0.52)
        size = spread * (0.72 if k == 0 else rng.uniform(0.42, 0.58))
        lump = clump(rng, size, paints[k % len(paints)])
        rise = height * (0.8 if k == 0 else rng.uniform(0.55, 0.74))
        parts.append(lump.moved(reach * math.cos(around), reach * math.sin(around), rise))
    return joined(parts)


def stone(rng: np.random.Generator) -> Shape:
    lump = clump(rng, 0.8, "Stone", 0.6)
    lump.slots = [
        SLOT["Moss"] if lump.vertices[face][:, 2].min() > 0.12 else SLOT["Stone"]
        for face in lump.faces
    ]
    return lump.moved(z=0.1)


def tuft(rng: np.random.Generator) -> Shape:
    """Blades of grass of one bend each."""
    blade = Shape(
        np.array([(-0.03, 0, 0), (0.03, 0, 0), (0, 0.05, 0.4), (0, 0.22, 0.7)]),
        [[0, 1, 2], [1, 3, 2], [2, 3, 0]],
    )
    turns = rng.uniform(0, 2 * math.pi, 18)
    blades = [
        blade.scaled(1, 1, rng.uniform(0.6, 1.1)).moved(y=rng.uniform(0.03, 0.22)).turned(z=turn)
        for turn in turns
    ]
    return joined(blades).painted(SLOT["Bright leaves"])


def species(rng: np.random.Generator) -> dict[str, Shape]:
    """Every plant, in the order of its number in the scene."""
    green, autumn = ("Leaves", "Bright leaves"), ("Autumn leaves", "Bright leaves")
    return {
        "0 Pine": pine(rng, 9.0, 2.3, 7),
        "1 Tall pine": pine(rng, 13.5, 2.2, 9),
        "2 Oak": leafy(rng, 8.0, 3.2, green, "Bark"),
        "3 Birch": leafy(rng, 8.5, 1.9, autumn, "Birch bark"),
        "4 Bush": joined(
            [clump(rng, 0.8, "Leaves").moved(z=0.4), clump(rng, 0.55, "Moss").moved(0.6, 0.2, 0.25)]
        ),
        "5 Stone": stone(rng),
        "6 Grass": tuft(rng),
    }
