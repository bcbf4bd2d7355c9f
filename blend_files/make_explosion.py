"""Makes explosion.blend: a boulder bursts into 5,600 shards, one deforming mesh of about 250,000
triangles.

Each shard flies a throw, a bounce and a spin that are formulas of scene time; geometry nodes
evaluate them per vertex.

    blender -b --factory-startup --python blend_files/make_explosion.py
"""

import sys
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

import flight
import fracture
import scene_kit as kit
import shapes

FRAMES, SHARDS, FUSE_SECONDS = 100, 5600, 0.25
PLINTH_RADIUS, PLINTH_HEIGHT, CENTRE_HEIGHT = 2.4, 0.7, 2.45


def main() -> None:
    kit.new_scene("Explosion", FRAMES, sky=(0.25, 0.35, 0.52))
    rng = np.random.default_rng(2007)
    shards = fracture.shatter(fracture.boulder((2.3, 2.1, 2.0), 72, rng), SHARDS, rng, 1 / 1024)
    crust = kit.material("Stone", (0.50, 0.46, 0.40), roughness=0.9)
    mesh = flight.shard_mesh("Shards", shards, crust, hot_core())
    thrown = flight.throw(
        shards.points + np.array([0, 0, CENTRE_HEIGHT]), shards.points, landing_height, rng
    )
    flight.store_flight(mesh, shards, thrown)
    source = kit.add_object("Shards", mesh, into=kit.source_collection())
    boulder = kit.add_object(
        "Boulder", bpy.data.meshes.new("Boulder"), location=(0, 0, CENTRE_HEIGHT)
    )
    flight.put_flight_on(boulder, source, FUSE_SECONDS)
    dress_the_set()
    kit.save("explosion")


def hot_core() -> list[bpy.types.Material]:
    """What the broken faces show, from the glowing core outwards."""
    return [
        kit.material("Glow", (1.0, 0.50, 0.07), emission=1.5),
        kit.material("Embers", (0.85, 0.20, 0.03), emission=0.4),
        kit.material("Burnt stone", (0.38, 0.15, 0.07)),
        kit.material("Broken stone", (0.27, 0.22, 0.18), roughness=0.9),
    ]


def landing_height(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height (N,) at which shards coming down at (N, 3) come to rest: the plinth's top or the
    ground.
    """
    on_plinth = np.hypot(places[:, 0], places[:, 1]) < PLINTH_RADIUS
    return np.where(on_plinth, PLINTH_HEIGHT, 0) + 0.07


def plinth() -> shapes.Shape:
    """A round base with a step and a chamfer."""
    steps = [(1.12, 0.0), (1.12, 0.3), (1.06, 0.36), (1.06, 0.85), (1.0, 1.0)]
    return shapes.lathe([(r * PLINTH_RADIUS, h * PLINTH_HEIGHT) for r, h in steps], 64)


def dress_the_set() -> None:
    """Ground, plinth, lamps with the flash of the blast, camera."""
    kit.ground(600, (0.42, 0.34, 0.24))
    stone = kit.material("Plinth", (0.32, 0.33, 0.36), roughness=0.8)
    kit.add_object("Plinth", shapes.mesh("Plinth", plinth(), [stone], smooth_below=0.5))
    kit.add_light("SUN", "Evening sun", (-20, -6, 12), (0, 0, 0), 3.2, (1.0, 0.86, 0.68), 0.01)
    kit.add_light("AREA", "Sky fill", (12, -10, 14), (0, 0, 2), 900, (0.62, 0.76, 1.0), 10)
    flash = kit.add_light(
        "POINT", "Flash", (0, 0, CENTRE_HEIGHT), (0, 0, 0), 0, (1.0, 0.5, 0.18), 0.4
    )
    start = FUSE_SECONDS * 24
    kit.animate(
        flash.data, "energy", [(start, 0), (start + 3, 4000), (start + 14, 900), (FRAMES, 0)]
    )
    kit.add_camera("Camera", (8.0, -13.5, 4.6), (0, 0, 2.9), lens=35)


if __name__ == "__main__":
    main()
