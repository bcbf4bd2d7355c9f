"""Bodies that pull one another, collide, and fly apart when gravity fades; NumPy, SI units."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STEPS_A_FRAME, FRAMES_A_SECOND = 16, 24.0
PULL, FADE_FRAME, FADE_FRAMES = 210.0, 52.0, 2.5  # G times all mass; when and how fast it fades
STIFFNESS, GIVE, SOFTENING = 9000.0, 4.0, 0.5  # of contacts, 1/s² and 1/s; metres
Array = NDArray[np.float64]


@dataclass
class Bodies:
    """Places and velocities (N, 3) in metres and m/s, radii (N,), shares of the whole mass (N,)."""

    place: Array
    velocity: Array
    radius: Array
    mass: Array


def scattered(count: int, reach: float, rng: np.random.Generator) -> Bodies:
    """A slowly turning cloud, `reach` metres in radius, in which no two bodies touch."""
    radius = np.sort(np.exp(rng.normal(-0.85, 0.32, count)).clip(0.22, 0.95))[::-1]
    place = np.empty((0, 3))
    while len(place) < count:
        dart = rng.uniform(-reach, reach, 3)
        gap = radius[: len(place)] + radius[len(place)] + 0.08
        clear = np.all(((place - dart) ** 2).sum(axis=1) > gap**2)
        if clear and np.linalg.norm(dart) < reach:
            place = np.vstack([place, dart])
    velocity = np.cross([0.08, -0.05, 0.30], place) + rng.normal(0, 0.25, place.shape)
    return Bodies(place, velocity, radius, radius**3 / (radius**3).sum())


def simulate(bodies: Bodies, frames: int) -> Iterator[Array]:
    """Yields the places (N, 3) at each frame; symplectic Euler steps."""
    step = 1 / (FRAMES_A_SECOND * STEPS_A_FRAME)
    for frame in range(frames):
        yield bodies.place.copy()
        pull = PULL / (1 + np.exp((frame - FADE_FRAME) / FADE_FRAMES))
        for _ in range(STEPS_A_FRAME):
            bodies.velocity += acceleration(bodies, pull) * step
            bodies.place += bodies.velocity * step


def acceleration(bodies: Bodies, pull: float) -> Array:
    """Softened gravity, and a damped spring between bodies that touch; (N, 3) in m/s²."""
    planes = bodies.place.T
    apart = planes[:, None, :] - planes[:, :, None]  # (3, N, N): from the first to the second
    squared = apart[0] ** 2 + apart[1] ** 2 + apart[2] ** 2
    gravity = pull * bodies.mass / ((squared + SOFTENING**2) * np.sqrt(squared + SOFTENING**2))
    total: Array = np.stack([(gravity * axis).sum(axis=1) for axis in apart], axis=1)
    touching = squared < np.add.outer(bodies.radius, bodies.radius) ** 2
    first, second = np.nonzero(touching & ~np.eye(len(touching), dtype=bool))
    np.add.at(total, first, contacts(bodies, first, second))
    return total


def contacts(bodies: Bodies, first: NDArray[np.int64], second: NDArray[np.int64]) -> Array:
    """Acceleration (P, 3) of the first body of each touching pair."""
    apart = bodies.place[second] - bodies.place[first]
    distance = np.sqrt((apart * apart).sum(axis=1, keepdims=True))
    normal = apart / distance
    overlap = (bodies.radius[first] + bodies.radius[second])[:, None] - distance
    approach = bodies.velocity[first] - bodies.velocity[second]
    closing = (approach * normal).sum(axis=1, keepdims=True)
    share = (bodies.mass[second] / (bodies.mass[first] + bodies.mass[second]))[:, None]
    return np.asarray(-normal * share * (STIFFNESS * overlap + GIVE * closing))
