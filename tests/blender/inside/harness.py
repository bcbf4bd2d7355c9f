"""What the checks share: a blank file before each, and ways to see what reached the library."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np

TEMPORARY = Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd()
# Corners and faces of a cube of side 2 about the origin.
CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]

SQUARE = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


def part(name: str = "") -> ModuleType:
    """A module of the add-on, wherever this Blender has installed it."""
    package = next(n for n in sys.modules if n.split(".")[-1] == "regraft_blender")
    __import__(f"{package}.{name}".rstrip("."))
    return sys.modules[f"{package}.{name}".rstrip(".")]


def run(names: dict[str, Any]) -> None:
    """Run every function `check_…` in a blank file of its own; exit with 1 if one fails."""
    checks = {n: f for n, f in names.items() if n.startswith("check_") and callable(f)}
    failed = []
    for name, check in checks.items():
        blank()
        try:
            check()
        except Exception:  # noqa: BLE001 - whatever it is, the other checks run as well
            failed.append(name)
            print(f"FAILED {name}\n{traceback.format_exc()}", flush=True)
    if failed:
        sys.exit(f"{len(failed)} of {len(checks)} checks failed: {', '.join(failed)}")
    print(f"{len(checks)} checks passed", flush=True)


def blank() -> bpy.types.Scene:
    """An empty file with a small picture, a camera 10 m above the origin, and our engine."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    part("session").close_all()
    part("session").clear_history()
    scene = bpy.context.scene
    scene.render.engine = "REGRAFT"
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.render.filepath = str(TEMPORARY / "frame_")
    scene.render.use_persistent_data = True
    scene.regraft.shading = "clay"
    scene.camera = add("camera", bpy.data.cameras.new("camera"), (0, 0, 10))
    return scene


def add(name: str, data: Any, location: tuple[float, float, float] = (0, 0, 0)) -> Any:
    """A new object in the scene's own collection."""
    ob = bpy.data.objects.new(name, data)
    ob.location = location
    bpy.context.scene.collection.objects.link(ob)
    return ob


def mesh(name: str, vertices: Any = SQUARE, faces: Any = ((0, 1, 2, 3),)) -> bpy.types.Mesh:
    """A mesh from coordinates; a square of 2 m unless told otherwise."""
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(v) for v in vertices], [], [tuple(f) for f in faces])
    return data


def paint(name: str, colour: tuple[float, float, float, float]) -> bpy.types.Material:
    """A rough material that is its viewport colour, in every version."""
    material = bpy.data.materials.new(name)
    material.diffuse_color, material.roughness = colour, 1.0
    if material.node_tree is not None:
        material.node_tree.nodes.clear()
    return material


def grid(name: str, side: int) -> bpy.types.Mesh:
    """side × side quads from 0 to 1."""
    line = np.linspace(0, 1, side + 1)
    points = [(x, y, 0.0) for y in line for x in line]
    quads = [
        (i, i + 1, i + side + 2, i + side + 1)
        for row in range(side)
        for i in range(row * (side + 1), row * (side + 1) + side)
    ]
    return mesh(name, points, quads)


def render(frame: int | None = None) -> dict[str, Any]:
    """Render the scene (at a frame); the frame's statistics."""
    if frame is not None:
        bpy.context.scene.frame_set(frame)
    assert bpy.ops.render.render() == {"FINISHED"}
    statistics: dict[str, Any] = part("session").last_statistics()
    return statistics


def native() -> Any:
    """The native scene of the only session."""
    (kept,) = part("session")._sessions.values()
    return kept.scene


def reads() -> Any:
    """How many meshes the last reading read."""
    (kept,) = part("session")._sessions.values()
    return kept._reader.objects.meshes.reads


def heights(*places: tuple[float, float]) -> list[float | None]:
    """Height of what lies under each place, looking down from 100 m; None for nothing."""
    origins = np.array([(x, y, 100.0) for x, y in places])
    hits = native().closest_hit(origins, np.tile([0.0, 0.0, -1.0], (len(places), 1)))
    return [round(100 - float(t), 4) if np.isfinite(t) else None for t in hits.t]


@contextmanager
def planes() -> Iterator[dict[str, np.ndarray]]:
    """What Blender's passes hold after they were filled, read back, first row at the bottom."""
    final = part("final_render")
    fill: Callable[..., None] = final._fill
    found: dict[str, np.ndarray] = {}

    def filled(target: Any, plane: Any) -> None:
        fill(target, plane)
        values = np.array([list(pixel) for pixel in target.rect], np.float32)
        found[target.name] = values.reshape(plane.shape)

    final._fill = filled
    try:
        yield found
    finally:
        final._fill = fill


def raises(kind: type[BaseException], action: Callable[[], object]) -> str:
    """The message of the exception that `action` must raise."""
    try:
        action()
    except kind as error:
        return str(error)
    raise AssertionError(f"{kind.__name__} was not raised")
