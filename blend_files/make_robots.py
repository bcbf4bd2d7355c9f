"""Makes robots.blend: five robots of 56 rigid parts walk through a workshop, 12 objects deep.

blender -b --factory-startup --python blend_files/make_robots.py
"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import robot_parts
import robot_walk
import scene_kit as kit
import shapes

FRAMES = 40
Parts = dict[str, bpy.types.Object]


@dataclass
class Character:
    """One robot: shell colour, start, size, place in the stride, and what its arms do."""

    color: tuple[float, float, float]
    place: tuple[float, float]
    size: float
    phase: float
    arms: tuple[robot_walk.Gesture, robot_walk.Gesture]
    heading: float = 0.0


SWING = robot_walk.swinging("L"), robot_walk.swinging("R")
CHARACTERS = {
    "Amber": Character(
        (0.80, 0.42, 0.05), (0.0, -0.2), 1.0, 0.0, (SWING[0], robot_walk.waving("R"))
    ),
    "Teal": Character((0.05, 0.38, 0.40), (-1.5, -1.4), 1.08, 0.5, SWING),
    "Cherry": Character(
        (0.60, 0.06, 0.07),
        (1.45, -1.5),
        0.92,
        0.3,
        (robot_walk.carrying("L"), robot_walk.carrying("R")),
    ),
    "Chalk": Character((0.72, 0.72, 0.68), (0.75, -3.4), 1.2, 0.75, SWING),
    "Sprout": Character((0.30, 0.50, 0.10), (1.1, 0.7), 0.55, 0.15, SWING),
}


def main() -> None:
    kit.new_scene("Robots", FRAMES, sky=(0.24, 0.28, 0.34))
    metal = kit.material("Metal", (0.34, 0.35, 0.37), roughness=0.35, metallic=0.8)
    rubber = kit.material("Rubber", (0.045, 0.045, 0.05), roughness=0.85)
    light = kit.material("Light", (1.0, 0.85, 0.45), emission=3.0)
    shell = kit.material("Shell", (0.5, 0.5, 0.5), roughness=0.4)
    meshes = {
        name: shapes.mesh(name, shape, [shell, metal, rubber, light], smooth_below=0.7)
        for name, shape in robot_parts.shapes_by_name().items()
    }
    crowd = kit.collection("Robots")
    for name, character in CHARACTERS.items():
        walk(character, build(name, character, meshes, kit.collection(name, crowd)))
    load_crate(bpy.data.objects["Cherry Chest"])
    dress_the_set()
    kit.save("robots")


def build(
    name: str, character: Character, meshes: dict[str, bpy.types.Mesh], into: bpy.types.Collection
) -> Parts:
    """One robot's objects, parented as robot_parts.TREE says, under an empty at its feet."""
    root = kit.add_object(name, None, location=(*character.place, 0), into=into)
    root.rotation_euler.z = character.heading
    root.scale = (character.size,) * 3
    shell = kit.material(f"{name} shell", character.color, roughness=0.4)
    parts: Parts = {"": root}
    for part, parent, place in robot_parts.TREE:
        for side, mirror in ((".L", -1), (".R", 1)) if part.endswith("*") else (("", 1),):
            title = part.rstrip("*") + side
            kind = part.rstrip("*")
            made = kit.add_object(
                f"{name} {title}",
                meshes[robot_parts.SHAPE_OF.get(kind, kind)],
                location=(place[0] * mirror, place[1], place[2]),
                parent=parts[parent.replace("*", side)],
                into=into,
            )
            made.material_slots[0].link = "OBJECT"
            made.material_slots[0].material = shell
            parts[title] = made
    return parts


def walk(character: Character, parts: Parts) -> None:
    """Bakes the walk: a key a frame on every joint that moves, and a steady advance of the root."""
    frames = range(1, FRAMES + 1)
    phases = [character.phase + (frame - 1) / robot_walk.PERIOD for frame in frames]
    poses = [pose(character, phase, frame) for phase, frame in zip(phases, frames, strict=True)]
    for part, axis in poses[0]:
        keys = [(frame, pose[part, axis]) for frame, pose in zip(frames, poses, strict=True)]
        kit.animate(parts[part], "rotation_euler", keys, index=axis)
    heights = [(f, robot_walk.hips_height(p)) for f, p in zip(frames, phases, strict=True)]
    kit.animate(parts["Hips"], "location", heights, index=2)
    way = robot_walk.STRIDE * character.size * (FRAMES - 1) / robot_walk.PERIOD
    for axis, step in enumerate((-math.sin(character.heading), math.cos(character.heading))):
        start = character.place[axis]
        kit.animate(parts[""], "location", [(1, start), (FRAMES, start + way * step)], index=axis)


def pose(character: Character, phase: float, frame: float) -> robot_walk.Pose:
    """All joint angles of one robot at one frame."""
    angles = robot_walk.body(phase) | robot_walk.leg("L", phase) | robot_walk.leg("R", phase + 0.5)
    for arm in character.arms:
        angles |= arm(phase, frame)
    return angles


def load_crate(chest: bpy.types.Object) -> None:
    """What the carrying robot carries."""
    wood = kit.material("Crate", (0.45, 0.28, 0.13))
    band = kit.material("Crate band", (0.22, 0.13, 0.06))
    kit.add_object(
        "Cherry crate",
        shapes.mesh("Small crate", crate(0.46), [wood, band]),
        location=(0, 0.52, 0.12),
        parent=chest,
        into=chest.users_collection[0],
    )


def crate(size: float) -> shapes.Shape:
    """A box of boards with battens along its edges."""
    bar, half = size * 0.12, size / 2
    parts = [shapes.box(size * 0.94, size * 0.94, size * 0.94)]
    for turn in ((0, 0, 0), (math.pi / 2, 0, 0), (0, math.pi / 2, 0)):
        for x in (-1, 1):
            for y in (-1, 1):
                post = shapes.box(bar, bar, size * 1.02).moved(
                    x * (half - bar / 2), y * (half - bar / 2)
                )
                parts.append(shapes.bevelled(post, bar * 0.15).turned(*turn).painted(1))
    return shapes.joined(parts)


def dress_the_set() -> None:
    """A workshop: tiled floor, wall with pillars and pipes, crates, lamps, camera."""
    hall = kit.collection("Workshop")
    tiled_floor(hall)
    walls(hall)
    wood, band = bpy.data.materials["Crate"], bpy.data.materials["Crate band"]
    mesh = shapes.mesh("Large crate", crate(0.9), [wood, band])
    for x, y, z, turn in (
        (-3.4, 2.2, 0.46, 0.3),
        (-3.5, 1.1, 0.46, -0.1),
        (-3.4, 1.7, 1.38, 0.15),
        (3.3, 2.0, 0.46, 0.5),
    ):
        kit.add_object("Crate", mesh, location=(x, y, z), rotation=(0, 0, turn), into=hall)
    kit.add_light("AREA", "Ceiling", (0, 0, 5.2), (0, 0, 0), 650, (1.0, 0.95, 0.88), 4.0)
    kit.add_light("SUN", "Gate", (4, 9, 7), (0, 0, 0), 2.0, (1.0, 0.90, 0.76), 0.02)
    camera = kit.add_camera("Camera", (2.3, 6.4, 1.75), (-0.1, -0.4, 0.95), lens=32)
    kit.animate(camera, "location", [(1, 2.3), (FRAMES, 2.0)], index=0)


def tiled_floor(into: bpy.types.Collection) -> None:
    """Two colours of tiles, each with a groove round it."""
    tile = shapes.bevelled(shapes.box(0.98, 0.98, 0.1), 0.012).moved(z=-0.05)
    colors = [
        kit.material("Tile", (0.42, 0.43, 0.44)),
        kit.material("Dark tile", (0.27, 0.28, 0.30)),
    ]
    parts = [tile.moved(x, y).painted((x + y) % 2) for x in range(-13, 8) for y in range(-8, 9)]
    kit.add_object("Floor", shapes.mesh("Floor", shapes.joined(parts), colors), into=into)
    under = kit.ground(40, (0.12, 0.12, 0.12), "Foundation")
    under.location.z = -0.02


def walls(into: bpy.types.Collection) -> None:
    """Behind the robots: a wall, pillars with a stripe of warning paint, and pipes."""
    plaster = kit.material("Plaster", (0.46, 0.40, 0.33))
    steel = kit.material("Girder", (0.20, 0.24, 0.28), metallic=0.3)
    paint = kit.material("Warning", (0.85, 0.62, 0.05))
    wall = shapes.mesh("Wall", shapes.box(22, 0.2, 5.5).moved(x=-3, z=2.75), [plaster])
    kit.add_object("Wall", wall, location=(0, -8.5, 0), into=into)
    post = shapes.bevelled(shapes.box(0.42, 0.42, 5.5), 0.05, 2).moved(z=2.75)
    stripe = shapes.box(0.44, 0.44, 0.28).moved(z=1.1).painted(1)
    pillar = shapes.mesh("Pillar", post + stripe, [steel, paint])
    for x in range(-12, 9, 3):
        kit.add_object("Pillar", pillar, location=(x, -8.2, 0), into=into)
    rings = [shapes.lathe([(0.15, x), (0.15, x + 0.12)], 24) for x in range(-8, 15, 2)]
    pipe = shapes.joined([shapes.lathe([(0.11, -8), (0.11, 14)], 24), *rings]).turned(
        y=-math.pi / 2
    )
    made = shapes.mesh("Pipe run", pipe, [steel], smooth_below=0.7)
    for z in (3.3, 3.75):
        kit.add_object("Pipe run", made, location=(0, -8.05, z), into=into)


if __name__ == "__main__":
    main()
