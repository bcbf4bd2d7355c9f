"""Makes n_body.blend: 450 spheres of 320 triangles fall together under gravity, collide and
scatter.

The motion is computed here and stored as sampled F-curves: nothing to bake, the same in every
Blender.

    blender -b --factory-startup --python blend_files/make_n_body.py
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

import n_body_sim
import scene_kit as kit
import shapes

FRAMES, BODIES, START_RADIUS = 130, 450, 9.5
Array = NDArray[np.float64]


def main() -> None:
    kit.new_scene("N-body", FRAMES, sky=(0.035, 0.045, 0.075))
    bodies = n_body_sim.scattered(BODIES, START_RADIUS, np.random.default_rng(450))
    start = np.linalg.norm(bodies.place, axis=1)
    tracks = np.stack(list(n_body_sim.simulate(bodies, FRAMES)))
    add_spheres(tracks, bodies.radius, start)
    light_and_camera()
    kit.save("n_body")


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


if __name__ == "__main__":
    main()
