"""Hills: heights as a sum of smooth random waves, and meshes that follow them, in metres."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapes
from numpy.typing import NDArray

Array = NDArray[np.float64]
Heights = Callable[[Array, Array], Array]


@dataclass
class Waves:
    """Octaves of plane waves in random directions: (O, W) directions and phases, wavelength halved
    each octave.
    """

    angles: Array
    phases: Array
    wavelength: float

    def __call__(self, x: Array, y: Array) -> Array:
        """Heights about zero, mostly within ±1, at any places of one shape."""
        total = np.zeros_like(x, dtype=float)
        for octave, (angles, phases) in enumerate(zip(self.angles, self.phases, strict=True)):
            rate = 2 * math.pi * 1.9**octave / self.wavelength
            for angle, phase in zip(angles, phases, strict=True):
                along = x * math.cos(angle) + y * math.sin(angle)
                total += np.sin(along * rate + phase) * 0.48**octave / math.sqrt(len(angles))
        return total


def waves(wavelength: float, octaves: int, rng: np.random.Generator) -> Waves:
    """Random waves; the longest is `wavelength` metres."""
    shape = octaves, 5
    return Waves(rng.uniform(0, 2 * math.pi, shape), rng.uniform(0, 2 * math.pi, shape), wavelength)


def surface(
    heights: Heights, half: float, cells: int, crowding: tuple[float, float]
) -> tuple[Array, NDArray[np.int64]]:
    """A square mesh over ±`half` metres: vertices (V, 3), quads.

    A `crowding` above 1, along X and along Y, makes the middle finer.
    """
    vertices, faces = shapes.grid(cells, cells)
    flat = vertices[:, :2] * 2 - 1
    flat = np.sign(flat) * np.abs(flat) ** np.array(crowding) * half
    return np.column_stack([flat, heights(flat[:, 0], flat[:, 1])]), faces
