"""Makes courtyard.blend: a static building of thousands of objects in a deep tree, seen from near
or far.

Courtyard > wing > floor > bay > window > flower box > shrub > blooms: eight parents deep, the same
nesting in collections down to the bay. Objects of one kind share one mesh. Camera "Overview" sees
nearly everything, "Detail" one window.

    blender -b --factory-startup --python blend_files/make_courtyard.py
"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import courtyard_parts as parts
import scene_kit as kit
import shapes
from courtyard_garden import garden_parts
from courtyard_parts import ARCADE, BAY, GROUND_FLOOR, SPRING, UPPER_FLOOR

FRAMES = 40
LONG, SHORT = 9, 7  # bays of the wings along X and Y
WIDTH, DEPTH = LONG * BAY, SHORT * BAY
Place = tuple[float, float, float]


@dataclass
class Site:
    """A place to build at: meshes by name, the parent of what is built, and its collection."""

    meshes: dict[str, bpy.types.Mesh]
    parent: bpy.types.Object
    into: bpy.types.Collection

    def put(
        self, mesh: str, place: Place = (0, 0, 0), turn: float = 0.0, title: str = ""
    ) -> "Site":
        """Adds an object of a shared mesh, turned about Z; returns it as a site of its own."""
        made = kit.add_object(
            title or mesh,
            self.meshes[mesh],
            location=place,
            rotation=(0, 0, turn),
            parent=self.parent,
            into=self.into,
        )
        return Site(self.meshes, made, self.into)

    def group(
        self, title: str, place: Place = (0, 0, 0), turn: float = 0.0, *, folder: bool = False
    ) -> "Site":
        """Adds an empty to hang things on, with a collection of its own if it is a `folder`."""
        into = kit.collection(title, self.into) if folder else self.into
        made = kit.add_object(
            title, None, location=place, rotation=(0, 0, turn), parent=self.parent, into=into
        )
        made.empty_display_size = 0.2
        return Site(self.meshes, made, into)


def main() -> None:
    kit.new_scene("Courtyard", FRAMES, sky=(0.40, 0.55, 0.78))
    rng = np.random.default_rng(1568)
    into = kit.collection("Courtyard")
    site = Site(build_meshes(rng), kit.add_object("Courtyard", None, into=into), into)
    for name, bays, place, quarter in (
        ("North", LONG, (0, DEPTH / 2, 0), 0),
        ("West", SHORT, (-WIDTH / 2, 0, 0), 1),
        ("South", LONG, (0, -DEPTH / 2, 0), 2),
        ("East", SHORT, (WIDTH / 2, 0, 0), 3),
    ):
        wing = site.group(f"{name} wing", place, quarter * math.pi / 2, folder=True)
        build_wing(wing, name, bays, rng)
    build_towers(site.group("Towers", folder=True))
    pave(site.group("Paving", folder=True), rng)
    plant(site.group("Garden", folder=True), rng)
    light_and_cameras()
    kit.save("courtyard")


def build_meshes(rng: np.random.Generator) -> dict[str, bpy.types.Mesh]:
    """One mesh a part, with only the materials it uses."""
    colors = {
        name: kit.material(
            name, color, roughness=0.75, emission=4.0 if name == "Lamplight" else 0.0
        )
        for name, color in parts.PALETTE.items()
    }
    names, meshes = list(colors), {}
    for title, shape in (parts.building_parts() | garden_parts(rng)).items():
        used = sorted(set(shape.slots))
        shape.slots = [used.index(slot) for slot in shape.slots]
        leafy = used == [parts.SLOT["Leaf"]]
        slots = [colors[names[slot]] for slot in used]
        meshes[title] = shapes.mesh(title, shape, slots, smooth_below=0.0 if leafy else 0.6)
    return meshes


def build_wing(wing: Site, name: str, bays: int, rng: np.random.Generator) -> None:
    """Two floors of bays and their roof."""
    floors = [
        wing.group(f"{name} arcade", folder=True),
        wing.group(f"{name} upper floor", (0, 0, GROUND_FLOOR), folder=True),
        wing.group(f"{name} roof", (0, 0, GROUND_FLOOR + UPPER_FLOOR), folder=True),
    ]
    builders = build_arcade_bay, build_upper_bay, build_roof_bay
    for number in range(bays):
        x = (number - (bays - 1) / 2) * BAY
        for floor, build, word in zip(floors, builders, ("arcade", "upper", "roof"), strict=True):
            build(
                floor.group(f"{name} {word} bay {number + 1}", (x, 0, 0), folder=True), number, rng
            )


def build_arcade_bay(bay: Site, number: int, rng: np.random.Generator) -> None:
    column = bay.group("Column", (-BAY / 2, 0, 0))
    for piece in ("Column base", "Column shaft", "Capital"):
        column.put(piece)
    arch = bay.put("Arch wall")
    ring = arch.group("Arch ring", (0, 0, SPRING))
    for stone in range(13):
        made = ring.put("Arch stone")
        made.parent.rotation_euler.y = (stone - 6) * math.pi / 13
    bay.put("Arcade floor", (0, ARCADE / 2, -0.02))
    ceiling = bay.put("Ceiling", (0, ARCADE / 2, GROUND_FLOOR - 0.3))
    ceiling.put("Lantern", (0, 0, -1.05)).put("Flame")
    wall = bay.put("Back wall", (0, ARCADE, 0))
    if number % 2:
        door = wall.put("Door frame", (0, -0.1, 0))
        for side, turn in ((-1, 0.0), (1, math.pi)):
            door.put("Door leaf", (0.44 * side, -0.1, 0), turn).put("Knob", (0.36, 0, 1.05))
    else:
        build_window(wall, (0, -0.2, 1.0), rng, with_flowers=False)


def build_upper_bay(bay: Site, number: int, rng: np.random.Generator) -> None:
    build_window(bay.put("Upper wall"), (0, 0, 0.95), rng, with_flowers=number % 2 == 0)
    slab = bay.put("Gallery slab", (0, -0.4, 0.07))
    for x in (-0.9, 0.9):
        slab.put("Bracket", (x, 0.2, -0.49))
    balustrade = slab.group("Balustrade", (0, -0.3, 0.07))
    for k in range(9):
        balustrade.put("Baluster", ((k - 4) * BAY / 9, 0, 0))
    balustrade.put("Hand rail", (0, 0, 0.73))


def build_window(wall: Site, place: Place, rng: np.random.Generator, *, with_flowers: bool) -> None:
    """A window in a wall, its shutters open by chance, flowers on the sill of some."""
    window = wall.put("Window frame", place, title="Window")
    sill = window.put("Sill", (0, -0.06, 0))
    for side, turn in ((-1, 0.0), (1, math.pi)):
        sash = window.put("Sash", (0.265 * side, 0.02, 0.02))
        sash.put("Glass")
        sash.put("Knob", (-0.18 * side, -0.03, 0.75))
        swing = rng.uniform(1.9, 2.9)
        window.put(
            "Shutter", (0.55 * side, -0.27, 0.03), turn - swing if side < 0 else turn + swing
        )
    if with_flowers:
        box = sill.put("Flower box", (0, -0.18, 0.12))
        for x in (-0.36, 0.0, 0.36):
            shrub = box.put("Shrub", (x, 0, 0.24), rng.uniform(0, 6))
            shrub.put("Blooms", (0, 0, 0), rng.uniform(0, 6))
        box.put("Trailer", (0, -0.14, -0.02), rng.uniform(-0.1, 0.1))


def build_roof_bay(bay: Site, _: int, __: np.random.Generator) -> None:
    bay.put("Cornice", (0, -0.15, 0.0))
    slope = bay.group("Slope", (0, -0.62, 0.12))
    slope.parent.rotation_euler.x = parts.PITCH
    for course in range(parts.COURSES):
        slope.put("Tile course", (0, course * parts.TILE_LENGTH * 0.9, 0))


def build_towers(towers: Site) -> None:
    """One at each corner, outside the courtyard's square."""
    for x in (-1, 1):
        for y in (-1, 1):
            tower = towers.put("Tower", (x * (WIDTH / 2 + 1.75), y * (DEPTH / 2 + 1.75), 0))
            tower.put("Tower roof", (0, 0, 9.3))


def pave(paving: Site, rng: np.random.Generator) -> None:
    """Patches of setts all over the court but under the fountain."""
    size = 1.35
    for row in range(round(DEPTH / size)):
        line = paving.group(f"Row {row + 1}", (0, (row + 0.5) * size - DEPTH / 2, 0))
        for column in range(round(WIDTH / size)):
            x, y = (column + 0.5) * size - WIDTH / 2, line.parent.location.y
            if math.hypot(x, y) > 1.9:
                line.put(f"Paving {rng.integers(4)}", (x, 0, 0), int(rng.integers(4)) * math.pi / 2)


def plant(garden: Site, rng: np.random.Generator) -> None:
    """Fountain, hedges, citrus trees in pots, benches."""
    steps = garden.put("Fountain steps")
    basin = steps.put("Basin", (0, 0, 0.3))
    basin.put("Water", (0, 0, 0.42))
    bowl = basin.put("Stem", (0, 0, 0.1)).put("Upper bowl", (0, 0, 1.46))
    bowl.put("Jet", (0, 0, 0.95))
    for x in (-1, 1):
        for y in (-1, 1):
            bed = garden.group("Bed", (x * 7.0, y * 4.9, 0))
            for k in (-1, 0, 1):
                bed.put("Hedge", (k * 2.1, y * 0.9, 0), rng.choice([0.0, math.pi]))
            for k in (-1, 1):
                pot = bed.put("Pot", (k * 2.3, -y * 0.9, 0))
                tree = pot.put("Trunk", (0, 0, 0.45), rng.uniform(0, 6))
                tree.put("Crown").put("Fruit")
            bed.put("Bench", (0, -y * 0.7, 0))
    for number in range(LONG - 1):
        for y in (-1, 1):
            pot = garden.put("Pot", ((number - (LONG - 2) / 2) * BAY, y * (DEPTH / 2 - 0.75), 0))
            pot.put("Shrub", (0, 0, 0.68), rng.uniform(0, 6)).put("Blooms")


def light_and_cameras() -> None:
    kit.ground(300, (0.33, 0.29, 0.22)).location.z = -0.12
    kit.add_light("SUN", "Sun", (-14, -9, 17), (0, 0, 0), 3.4, (1.0, 0.90, 0.74), 0.01)
    kit.add_light("AREA", "Sky fill", (0, 0, 22), (0, 0, 0), 2600, (0.70, 0.82, 1.0), 16)
    kit.add_camera("Detail", (-1.35, 7.0, 5.85), (0.05, 9.3, 5.3), lens=42)
    overview = kit.add_camera("Overview", (10.9, -8.6, 9.6), (-1.2, 1.6, 1.7), lens=22)
    kit.animate(overview, "location", [(1, 10.9), (FRAMES, 9.9)], index=0)


if __name__ == "__main__":
    main()
