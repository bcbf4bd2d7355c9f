"""Makes forest.blend: a valley of 27,000 plants, geometry-nodes instances of seven small meshes.

Most stand still, so their object is evaluated once; the ones near the track sway in the wind, and
the camera walks along it.

    blender -b --factory-startup --python blend_files/make_forest.py
"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

import forest_trees
import scene_kit as kit
import shapes
import terrain
from field_kit import Graph

FRAMES, SWAYING, UNDERGROWTH = 40, 900, 6000
CENTRE, HALF, SPACING = 195.0, 235.0, 3.1  # metres along Y; half the valley's side; between trees
POND, WATER_HEIGHT = (22.0, 50.0, 9.5), -1.1  # x, y, radius
Array = NDArray[np.float64]


@dataclass
class Plants:
    """Feet (N, 3) in metres, species (N,), sizes (N,), turns about Z (N,) in radians."""

    place: Array
    species: NDArray[np.int64]
    size: Array
    turn: Array

    def only(self, chosen: NDArray[np.bool_]) -> "Plants":
        return Plants(
            self.place[chosen], self.species[chosen], self.size[chosen], self.turn[chosen]
        )


def main() -> None:
    kit.new_scene("Forest", FRAMES, sky=(0.48, 0.60, 0.74))
    rng = np.random.default_rng(31)
    heights = valley(rng)
    add_ground(heights)
    sorts = add_species(rng)
    plants = sow(heights, rng)
    near = np.linalg.norm(plants.place[:, :2] - (track(25.0), 25.0), axis=1)
    windy = near <= np.sort(near)[SWAYING - 1]
    plant("Forest", plants.only(~windy), sorts, wind=False)
    plant("Forest in the wind", plants.only(windy), sorts, wind=True)
    light_and_camera()
    kit.save("forest")


def track(y: float) -> float:
    """Where the track runs, x at y."""
    return 9.0 * math.sin(y / 34.0)


def from_track(x: Array, y: Array) -> Array:
    """Distance from the track, metres (measured along X)."""
    return np.asarray(np.abs(x - 9.0 * np.sin(y / 34.0)))


def from_pond(x: Array, y: Array) -> Array:
    """Distance from the pond's shore, negative inside."""
    return np.asarray(np.hypot(x - POND[0], y - POND[1]) - POND[2])


def valley(rng: np.random.Generator) -> terrain.Heights:
    """Slopes that rise from the track on both sides, with a pond beside it."""
    rough, soft = terrain.waves(90, 4, rng), terrain.waves(26, 3, rng)

    def heights(x: Array, y: Array) -> Array:
        away = from_track(x, y)
        slope = 30 * (1 - np.exp(-((np.maximum(away - 7, 0) / 62) ** 1.5)))
        hills = slope * (1 + 0.35 * rough(x, y)) + 0.55 * soft(x, y) * np.minimum(1, away / 12)
        land = hills + 0.06 * np.maximum(y - 60, 0)
        shore = 1 / (1 + np.exp((from_pond(x, y) - 1.5) / 1.2))
        return np.asarray(land * (1 - shore) + (WATER_HEIGHT - 1.2) * shore)

    return heights


def add_ground(heights: terrain.Heights) -> None:
    """Grass with a trodden track and a pond."""
    vertices, faces = terrain.surface(lambda x, y: heights(x, y + CENTRE), HALF, 150, (1.7, 1.0))
    middle = vertices[faces].mean(axis=1) + np.array([0, CENTRE, 0])
    colors = [
        kit.material("Grass", (0.17, 0.24, 0.06), roughness=0.95),
        kit.material("Track", (0.36, 0.27, 0.17), roughness=0.95),
        kit.material("Sand", (0.50, 0.43, 0.29), roughness=0.95),
    ]
    mesh = kit.mesh_from_arrays("Ground", kit.quantised(vertices, 1 / 256), faces, colors)
    paint = np.where(from_track(middle[:, 0], middle[:, 1]) < 1.9, 1, 0)
    paint[from_pond(middle[:, 0], middle[:, 1]) < 2.2] = 2
    mesh.polygons.foreach_set("material_index", paint.astype(np.int32))
    kit.shade_smooth(mesh)
    kit.add_object("Ground", mesh, location=(0, CENTRE, 0))
    water = kit.ground(POND[2] + 4, (0.07, 0.20, 0.26), "Pond")
    water.location = (POND[0], POND[1], WATER_HEIGHT)


def add_species(rng: np.random.Generator) -> bpy.types.Collection:
    """The seven plants in a hidden collection."""
    colors = [
        kit.material(name, color, roughness=0.9) for name, color in forest_trees.PALETTE.items()
    ]
    sources = kit.source_collection()
    for name, shape in forest_trees.species(rng).items():
        used = sorted(set(shape.slots))
        shape.slots = [used.index(slot) for slot in shape.slots]
        kit.add_object(
            name, shapes.mesh(name, shape, [colors[slot] for slot in used]), into=sources
        )
    return sources


def sow(heights: terrain.Heights, rng: np.random.Generator) -> Plants:
    """A wood with a meadow along the track, and undergrowth where the camera passes."""
    line = np.arange(-HALF + 6, HALF - 6, SPACING)
    wood = np.stack(np.meshgrid(line, line + CENTRE), axis=-1).reshape(-1, 2)
    wood = wood + rng.uniform(-0.4, 0.4, wood.shape) * SPACING
    low = rng.normal(0, (17, 26), (UNDERGROWTH * 2, 2)) + np.array([2, 26])
    trees = rng.choice(5, len(wood), p=(0.40, 0.27, 0.15, 0.13, 0.05))
    bushes = 4 + rng.choice(3, len(low), p=(0.05, 0.03, 0.92))
    x, y = np.concatenate([wood, low]).T
    species = np.concatenate([trees, bushes])
    meadow = 8 + 7 * np.exp(-(((y - 14) / 34) ** 2))
    room = np.where(species < 4, meadow, 2.3)
    free = (from_track(x, y) > room) & (from_pond(x, y) > np.where(species < 4, 4, 1.5))
    chosen = np.nonzero(free)[0]
    chosen = chosen[: int(free[: len(wood)].sum()) + UNDERGROWTH]
    place = np.column_stack([x, y, heights(x, y)])[chosen]
    count = len(chosen)
    size, turn = rng.uniform(0.65, 1.3, count), rng.uniform(0, 2 * math.pi, count)
    return Plants(place, species[chosen], size, turn)


def plant(title: str, plants: Plants, sorts: bpy.types.Collection, *, wind: bool) -> None:
    """An object of points with a plant instanced on each."""
    place = kit.quantised(plants.place, 1 / 128)
    points = bpy.data.meshes.new(title)
    points.vertices.add(len(place))
    points.vertices.foreach_set("co", place.ravel())
    kit.set_attribute(points, "species", plants.species)
    kit.set_attribute(points, "size", kit.quantised(plants.size, 1 / 64))
    kit.set_attribute(points, "turn", kit.quantised(plants.turn, 1 / 32))
    grow(kit.add_object(title, points), sorts, wind=wind)


def grow(thing: bpy.types.Object, sorts: bpy.types.Collection, *, wind: bool) -> None:
    """The node tree that stands the plants on their points, leaning with the wind if any."""
    graph = Graph("Plants in the wind" if wind else "Plants")
    info = graph.node("GeometryNodeCollectionInfo", transform_space="ORIGINAL")
    info.inputs["Collection"].default_value = sorts
    info.inputs["Separate Children"].default_value = True
    info.inputs["Reset Children"].default_value = True
    node = graph.node("GeometryNodeInstanceOnPoints")
    node.inputs["Pick Instance"].default_value = True
    turn, size = graph.named("turn", "float"), graph.named("size", "float")
    graph.connect(info.outputs[0], node.inputs["Instance"])
    graph.connect(graph.named("species", "int"), node.inputs["Instance Index"])
    graph.connect(graph.vector(0.0, 0.0, turn), node.inputs["Rotation"])
    graph.connect(size, node.inputs["Scale"])
    graph.pass_through(node, "Instances")
    if wind:
        sway(graph)
    graph.put_on(thing)


def sway(graph: Graph) -> None:
    """Leans every plant to and fro, each at its own moment."""
    node = graph.pass_through(graph.node("GeometryNodeRotateInstances"), "Instances")
    node.inputs["Local Space"].default_value = False
    own = graph.named("turn", "float")
    seconds = graph.seconds()
    gust = (seconds * 2.3 + own).sine() + (seconds * 4.1 + own * 2.0).sine() * 0.4
    graph.connect(graph.vector(gust * 0.02, gust * 0.035 + 0.03, 0.0), node.inputs["Rotation"])


def light_and_camera() -> None:
    kit.add_light("SUN", "Sun", (-18, 4, 13), (0, 0, 0), 3.6, (1.0, 0.87, 0.66), 0.01)
    walk = [(1, -9.0), (FRAMES, 3.0)]
    camera = kit.add_camera("Camera", (track(-9) - 1.0, -9, 7.5), (6.0, 42.0, 3.0), lens=27)
    camera.data.clip_end = 900
    kit.animate(camera, "location", [(f, track(y) - 1.0) for f, y in walk], index=0)
    kit.animate(camera, "location", walk, index=1)


if __name__ == "__main__":
    main()
