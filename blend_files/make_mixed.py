"""Makes mixed.blend: one flat mesh; a landscape stands still, a rock bursts, a flag waves.

The parts are joined once a file by a source object; a frame moves only the shards and the flag.

    blender -b --factory-startup --python blend_files/make_mixed.py
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
import terrain
from field_kit import Field, Graph

FRAMES, SHARDS, FUSE_SECONDS = 60, 1300, 0.33
ROCK, POLE = np.array([-4.2, 1.0]), np.array([4.4, 0.4])
POLE_HEIGHT, FLAG_WIDTH, FLAG_HEIGHT = 10.0, 6.0, 3.8
Array = NDArray[np.float64]


def main() -> None:
    kit.new_scene("Mixed", FRAMES, sky=(0.32, 0.45, 0.64))
    rng = np.random.default_rng(20)
    heights = valley(rng)
    sources = kit.source_collection()
    parts = [
        add_landscape(heights, sources),
        add_rock(heights, rng, sources),
        add_flag(heights, sources),
        add_pole(heights, sources),
    ]
    joined = kit.add_object("Joined parts", bpy.data.meshes.new("Joined parts"), into=sources)
    join(parts, joined)
    move(kit.add_object("Valley", bpy.data.meshes.new("Valley")), joined)
    light_and_camera()
    kit.save("mixed")


def valley(rng: np.random.Generator) -> terrain.Heights:
    """A meadow with mountains round it, open towards the camera."""
    rough, soft = terrain.waves(46, 6, rng), terrain.waves(23, 3, rng)

    def heights(x: Array, y: Array) -> Array:
        away = np.hypot(x, y * 0.9 - 2)
        rise = np.clip((away - 16) / 44, 0, 1.3)
        ridge = 1 - np.abs(rough(x, y))
        behind = 1 / (1 + np.exp(-(y + 12) / 9))
        return np.asarray(0.28 * soft(x, y) + rise**1.3 * (6 + 17 * ridge) * behind)

    return heights


def add_landscape(heights: terrain.Heights, into: bpy.types.Collection) -> bpy.types.Object:
    """The ground, stored coarse; grass, bare rock and snow by slope and height once it is fine."""
    vertices, faces = terrain.surface(heights, 78, 80, (1.7, 1.7))
    grass, bare, snow = (
        kit.material("Grass", (0.17, 0.27, 0.06), roughness=0.95),
        kit.material("Bare rock", (0.27, 0.25, 0.23), roughness=0.9),
        kit.material("Snow", (0.82, 0.85, 0.90), roughness=0.6),
    )
    mesh = kit.mesh_from_arrays("Landscape", kit.quantised(vertices, 1 / 512), faces, [grass])
    kit.shade_smooth(mesh)
    land = kit.add_object("Landscape", mesh, into=into)
    refine(land, 2, "CATMULL_CLARK")
    graph = Graph("Grow and snow")
    place, normal = graph.position(), graph.node("GeometryNodeInputNormal").outputs[0]
    height, up = place.split()[2], Field(graph, normal).split()[2]
    graph.set_material(bare, (up * -1.0) + (height * -0.006) + 0.80)
    graph.set_material(snow, height + up * 9.0 - 20.5)
    graph.put_on(land)
    return land


def refine(thing: bpy.types.Object, levels: int, kind: str) -> None:
    modifier = thing.modifiers.new("Fine", "SUBSURF")
    modifier.subdivision_type = kind
    modifier.levels = modifier.render_levels = levels


def add_rock(
    heights: terrain.Heights, rng: np.random.Generator, into: bpy.types.Collection
) -> bpy.types.Object:
    """The shards of a boulder half sunk into the meadow, in world places."""
    shards = fracture.shatter(fracture.boulder((2.9, 2.5, 2.7), 54, rng), SHARDS, rng, 1 / 512)
    outward = shards.points + np.array([0, 0, 1.2])
    shards = shards.moved(np.array([*ROCK, heights(ROCK[0], ROCK[1]) + 1.7]))
    crust = kit.material("Rock", (0.42, 0.38, 0.34), roughness=0.9)
    inside = [
        kit.material("Core", (0.95, 0.42, 0.06), emission=0.8),
        kit.material("Ochre", (0.60, 0.26, 0.09)),
        kit.material("Split rock", (0.33, 0.24, 0.18)),
    ]
    mesh = flight.shard_mesh("Shards", shards, crust, inside)
    thrown = flight.throw(
        shards.points, outward, lambda places: heights(places[:, 0], places[:, 1]) + 0.1, rng
    )
    flight.store_flight(mesh, shards, thrown)
    source = kit.add_object("Shards", mesh, into=into)
    flight.prepare_shards(source)
    return source


def add_flag(heights: terrain.Heights, into: bpy.types.Collection) -> bpy.types.Object:
    """Three stripes, hanging still; `loose` says how far from the pole (m) a point is."""
    vertices, faces = shapes.grid(20, 12)
    foot = heights(POLE[0], POLE[1])
    x, z = vertices[:, 0] * FLAG_WIDTH, vertices[:, 1] * FLAG_HEIGHT
    top = foot + POLE_HEIGHT - 0.3
    placed = np.stack([POLE[0] + 0.09 + x, np.full(len(x), POLE[1]), top - FLAG_HEIGHT + z], axis=1)
    stripes = [
        kit.material("Flag amber", (0.85, 0.42, 0.04)),
        kit.material("Flag cream", (0.85, 0.84, 0.80)),
        kit.material("Flag teal", (0.02, 0.26, 0.28)),
    ]
    mesh = kit.mesh_from_arrays("Flag", placed, faces, stripes)
    mesh.polygons.foreach_set("material_index", (np.arange(len(faces)) // 20 // 4).astype(np.int32))
    kit.shade_smooth(mesh)
    kit.set_attribute(mesh, "loose", x)
    flag = kit.add_object("Flag", mesh, into=into)
    refine(flag, 3, "SIMPLE")
    return flag


def add_pole(heights: terrain.Heights, into: bpy.types.Collection) -> bpy.types.Object:
    """The flag's pole on its steps."""
    foot = float(heights(POLE[0], POLE[1]))
    steps = shapes.joined(
        [shapes.box(w, w, 0.3).moved(z=0.1 + 0.3 * k) for k, w in enumerate((2.2, 1.5, 0.9))]
    )
    rod = shapes.lathe(
        [(0.1, 0.5), (0.06, POLE_HEIGHT), (0.14, POLE_HEIGHT + 0.08), (0.0, POLE_HEIGHT + 0.3)], 24
    )
    shape = (steps + rod.painted(1)).moved(POLE[0], POLE[1], foot)
    materials = [
        kit.material("Steps", (0.5, 0.48, 0.44)),
        kit.material("Pole", (0.75, 0.72, 0.65), metallic=0.4),
    ]
    return kit.add_object("Pole", shapes.mesh("Pole", shape, materials), into=into)


def join(parts: list[bpy.types.Object], whole: bpy.types.Object) -> None:
    """Makes `whole` the union of the parts; what one part lacks of another's attributes is zero."""
    graph = Graph("Join the parts")
    node = graph.node("GeometryNodeJoinGeometry")
    for part in reversed(parts):  # the last link made comes first
        graph.connect(graph.object_geometry(part), node.inputs[0])
    graph.geometry = node.outputs[0]
    graph.put_on(whole)


def move(valley_object: bpy.types.Object, joined: bpy.types.Object) -> None:
    """Sets shards and flag in motion and leaves every other vertex alone."""
    graph = Graph("Burst and wave")
    graph.geometry = graph.object_geometry(joined)
    seconds = graph.seconds()
    flying = graph.named("times", "vector").split()[1]
    graph.move_by(flight.flight_offset(graph, seconds - FUSE_SECONDS), only=flying)
    loose = graph.named("loose", "float")
    graph.move_by(wave(graph, loose, seconds), only=loose)
    graph.put_on(valley_object)


def wave(graph: Graph, loose: Field, seconds: Field) -> Field:
    """How far a point of the flag is from hanging still; waves grow from the pole outwards."""
    height = graph.position().split()[2]
    long = (loose * 1.45 - seconds * 8.5 + height * 0.22).sine()
    short = (loose * 3.1 - seconds * 13.0 - height * 0.5).sine()
    side = loose * 0.15 * (long + short * 0.33)
    back = loose * (long * long * 0.05 - 0.09)
    sag = loose * (short * 0.03 - 0.055)
    return graph.vector(back, side, sag)


def light_and_camera() -> None:
    kit.add_light("SUN", "Sun", (-16, -13, 14), (0, 0, 0), 3.0, (1.0, 0.90, 0.74), 0.01)
    kit.add_light("AREA", "Sky fill", (10, -14, 12), (0, 0, 3), 500, (0.65, 0.78, 1.0), 8)
    camera = kit.add_camera("Camera", (0.8, -17.5, 3.4), (0.4, 0, 4.6), lens=27)
    camera.data.clip_end = 500


if __name__ == "__main__":
    main()
