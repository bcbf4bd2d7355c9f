"""Makes n_body.blend: 450 spheres of 320 triangles fall together under gravity, collide and
scatter.

The motion is computed here and stored as sampled F-curves: nothing to bake, the same in every
Blender.

    blender -b --factory-startup --python blend_files/make_n_body.py
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

import scene_kit as kit
import shapes

FRAMES, BODIES, STEPS_A_FRAME = 130, 450, 20
START_RADIUS, PULL, FADE_FRAME = 9.5, 210.0, 52  # metres, G times all mass, when gravity fades away
STIFFNESS, GIVE, SOFTENING = 9000.0, 4.0, 0.5  # of contacts, 1/s² and 1/s; metres
Array = NDArray[np.float64]


@dataclass
class Bodies:
    """Places and velocities (N, 3) in metres and m/s, radii (N,), shares of the whole mass (N,)."""

    place: Array
    velocity: Array
    radius: Array
    mass: Array


def main() -> None:
    kit.new_scene("N-body", FRAMES, sky=(0.035, 0.045, 0.075))
    bodies = scattered(np.random.default_rng(450))
    start = np.linalg.norm(bodies.place, axis=1)
    tracks = np.stack(list(simulate(bodies)))
    add_spheres(tracks, bodies.radius, start)
    light_and_camera()
    kit.save("n_body")


def scattered(rng: np.random.Generator) -> Bodies:
    """A slowly turning cloud in which no two bodies touch."""
    radius = np.sort(np.exp(rng.normal(-0.85, 0.32, BODIES)).clip(0.22, 0.95))[::-1]
    place: list[Array] = []
    while len(place) < BODIES:
        dart = rng.uniform(-START_RADIUS, START_RADIUS, 3)
        gap = radius[: len(place)] + radius[len(place)] + 0.08
        clear = all(np.linalg.norm(np.reshape(place, (-1, 3)) - dart, axis=1) > gap)
        if clear and np.linalg.norm(dart) < START_RADIUS:
            place.append(dart)
    points = np.array(place)
    velocity = np.cross([0.08, -0.05, 0.30], points) + rng.normal(0, 0.25, points.shape)
    return Bodies(points, velocity, radius, radius**3 / (radius**3).sum())


def simulate(bodies: Bodies) -> Iterator[Array]:
    """Yields the places (N, 3) at each frame; symplectic Euler steps."""
    step = 1 / (24 * STEPS_A_FRAME)
    for frame in range(FRAMES):
        yield bodies.place.copy()
        pull = PULL / (1 + np.exp((frame - FADE_FRAME) / 2.5))
        for _ in range(STEPS_A_FRAME):
            bodies.velocity += acceleration(bodies, pull) * step
            bodies.place += bodies.velocity * step


def acceleration(bodies: Bodies, pull: float) -> Array:
    """Softened gravity, and a damped spring between bodies that touch; (N, 3) in m/s²."""
    apart = bodies.place[None, :] - bodies.place[:, None]
    squared = (apart * apart).sum(axis=-1)
    gravity = pull * bodies.mass[None, :] / (squared + SOFTENING**2) ** 1.5
    total: Array = np.einsum("ij,ijk->ik", gravity, apart)
    first, second = np.nonzero(squared < np.add.outer(bodies.radius, bodies.radius) ** 2)
    first, second = first[first != second], second[first != second]
    distance = np.sqrt(squared[first, second])[:, None]
    normal = apart[first, second] / distance
    overlap = (bodies.radius[first] + bodies.radius[second])[:, None] - distance
    approach = bodies.velocity[first] - bodies.velocity[second]
    closing = (approach * normal).sum(axis=1, keepdims=True)
    share = (bodies.mass[second] / (bodies.mass[first] + bodies.mass[second]))[:, None]
    np.add.at(total, first, -normal * share * (STIFFNESS * overlap + GIVE * closing))
    return total


def add_spheres(tracks: Array, radius: Array, start: Array) -> None:
    """One shared mesh; the colour tells how far out a body began."""
    palette = [
        kit.material("Gold", (0.95, 0.62, 0.12), roughness=0.35),
        kit.material("Orange", (0.88, 0.30, 0.05), roughness=0.4),
        kit.material("Crimson", (0.60, 0.04, 0.07), roughness=0.4),
        kit.material("Violet", (0.25, 0.08, 0.42), roughness=0.45),
        kit.material("Blue", (0.05, 0.20, 0.55), roughness=0.45),
        kit.material("Ice", (0.55, 0.75, 0.85), roughness=0.3),
    ]
    mesh = shapes.mesh("Sphere", shapes.icosphere(1.0, 3), palette[:1])
    kit.shade_smooth(mesh)
    shell = np.minimum((start / START_RADIUS) ** 2.2 * len(palette), len(palette) - 1).astype(int)
    into = kit.collection("Bodies")
    for number in range(BODIES):
        body = kit.add_object(f"Body {number + 1:03}", mesh, into=into)
        body.scale = (float(radius[number]),) * 3
        body.material_slots[0].link = "OBJECT"
        body.material_slots[0].material = palette[shell[number]]
        kit.animate_by_samples(body, "location", kit.quantised(tracks[:, number], 1 / 512))


def light_and_camera() -> None:
    kit.add_light("SUN", "Key", (-12, -10, 14), (0, 0, 0), 3.4, (1.0, 0.93, 0.82), 0.02)
    kit.add_light("SUN", "Rim", (14, 16, -2), (0, 0, 0), 1.6, (0.40, 0.60, 1.0), 0.02)
    kit.add_light("POINT", "Heart", (0, 0, 0), (0, 0, 1), 700, (1.0, 0.55, 0.2), 0.3)
    kit.add_camera("Camera", (9, -28, 9), (0, 0, -0.1), lens=34)


main()
