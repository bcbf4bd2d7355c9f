"""Makes cloth.blend: a cloth of 93,312 triangles falls over a ball that starts to turn and winds it
up.

The cloth is simulated here on a coarse grid and baked to absolute shape keys, one a frame; a
subdivision surface makes it fine. It needs no cache and plays back alike in every Blender.

    blender -b --factory-startup --python blend_files/make_cloth.py
"""

import math
import sys
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

import cloth_sim
import scene_kit as kit
import shapes

FRAMES, TURN_STARTS = 80, 31
TURN_RATE, TURN_EASE = 2.4 / 24, 10.0  # radians a frame in the end; frames to get there


def main() -> None:
    kit.new_scene("Cloth", FRAMES, sky=(0.28, 0.30, 0.34))
    settings = cloth_sim.Settings()
    frames = list(cloth_sim.simulate(settings, FRAMES, ball_turn))
    add_cloth(frames)
    add_ball(settings.ball_radius)
    dress_the_set()
    kit.save("cloth")


def ball_turn(frame: float) -> float:
    """The ball's angle in radians, `frame` frames after the first: at rest, then smoothly up to a
    steady turn.
    """
    late = max(0.0, frame + 1 - TURN_STARTS)
    return TURN_RATE * (late - TURN_EASE * (1 - math.exp(-late / TURN_EASE)))


def add_cloth(frames: list[NDArray[np.float64]]) -> None:
    """The coarse cloth with a shape key a frame, its hem and cross stripes in other colours."""
    cells = frames[0].shape[0] - 1
    _, faces = shapes.grid(cells, cells)
    colors = [
        kit.material("Cloth", (0.62, 0.07, 0.06), roughness=0.9),
        kit.material("Hem", (0.85, 0.62, 0.25), roughness=0.8),
    ]
    points = [kit.quantised(frame.reshape(-1, 3), 1 / 2048) for frame in frames]
    mesh = kit.mesh_from_arrays("Cloth", points[0], faces, colors)
    row, column = np.divmod(np.arange(cells * cells), cells)
    edge = np.minimum.reduce([row, column, cells - 1 - row, cells - 1 - column])
    mesh.polygons.foreach_set("material_index", np.isin(edge, (1, 2, 4, 14)).astype(np.int32))
    kit.shade_smooth(mesh)
    cloth = kit.add_object("Cloth", mesh)
    bake(cloth, points)
    smooth = cloth.modifiers.new("Fine", "SUBSURF")
    smooth.levels = smooth.render_levels = 2


def bake(cloth: bpy.types.Object, points: list[NDArray[np.float32]]) -> None:
    """One absolute shape key a frame, played by an animated evaluation time."""
    for number, vertices in enumerate(points, start=1):
        key = cloth.shape_key_add(name=f"{number}", from_mix=False)
        key.interpolation = "KEY_LINEAR"
        key.data.foreach_set("co", vertices.ravel())
    keys = cloth.data.shape_keys
    keys.use_relative = False
    last = keys.key_blocks[-1].frame
    kit.animate(keys, "eval_time", [(1, keys.key_blocks[0].frame), (len(points), last)])


def add_ball(radius: float) -> None:
    """The striped ball, turning as the simulation took it to turn."""
    arc = [
        (math.cos(a) * radius, math.sin(a) * radius) for a in np.linspace(-1, 1, 33) * math.pi / 2
    ]
    profile = [(0.0, -radius), *arc[1:-1], (0.0, radius)]
    shape = shapes.lathe(profile, 64)
    middles = np.array([shape.vertices[face].mean(axis=0) for face in shape.faces])
    stripe = np.floor(np.arctan2(middles[:, 1], middles[:, 0]) / math.pi * 6) % 2
    shape.slots = [int(slot) for slot in stripe]
    paint = [kit.material("Ball", (0.75, 0.75, 0.72)), kit.material("Stripe", (0.05, 0.16, 0.30))]
    mesh = shapes.mesh("Ball", shape, paint, smooth_below=1.0)
    ball = kit.add_object("Ball", mesh, location=(0, 0, radius))
    turns = [(frame, ball_turn(frame - 1)) for frame in range(TURN_STARTS - 1, FRAMES + 1)]
    kit.animate(ball, "rotation_euler", turns, index=2)


def dress_the_set() -> None:
    """Floor, lamps, camera."""
    kit.ground(60, (0.50, 0.46, 0.40), "Floor")
    kit.add_light("AREA", "Window", (-3.2, -2.4, 3.6), (0, 0, 0.6), 170, (1.0, 0.95, 0.86), 1.6)
    kit.add_light("SUN", "Sun", (3, -2, 5), (0, 0, 0), 1.2, (0.85, 0.92, 1.0), 0.05)
    kit.add_camera("Camera", (2.2, -4.0, 2.5), (0, 0, 0.42), lens=39)


if __name__ == "__main__":
    main()
