"""Measures example scenes: what they hold and where everything is, as numbers to compare.

blender -b --factory-startup --python blend_files/measure.py        # writes measured.json
python measure.py FILE.blend RESULT.json                            # one file, in any Blender
"""

import json
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

FOLDER = Path(__file__).resolve().parent
MIDDLE_FRAME = 20
Numbers = dict[str, list[float]]


def measure(path: Path) -> dict[str, Any]:
    """The scene's settings, counts, and positions at its first, middle and last frame."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    scene = bpy.context.scene
    first, last = scene.frame_start, scene.frame_end
    jumped = positions_at(MIDDLE_FRAME)
    for frame in range(first, MIDDLE_FRAME):
        scene.frame_set(frame)
    return {
        "frames": [first, last],
        "fps": scene.render.fps,
        "resolution": [scene.render.resolution_x, scene.render.resolution_y],
        "view_transform": scene.view_settings.view_transform,
        "cameras": sorted(thing.name for thing in scene.objects if thing.type == "CAMERA"),
        "lights": sum(thing.type == "LIGHT" for thing in scene.objects),
        **counts(),
        "positions": {
            str(first): positions_at(first),
            str(MIDDLE_FRAME): positions_at(MIDDLE_FRAME),
            str(last): positions_at(last),
        },
        "middle_jumped_to": jumped,
    }


def counts() -> dict[str, int]:
    """Visible mesh objects and instances, their triangles, and the longest chain of parents."""
    triangles: dict[str, int] = {}
    total = {"objects": 0, "instances": 0, "triangles": 0, "depth": 0}
    for item in bpy.context.evaluated_depsgraph_get().object_instances:
        if item.object.type != "MESH":
            continue
        key = shape_key(item.object)
        if key not in triangles:
            triangles[key] = triangle_count(item.object.data)
        total["instances" if item.is_instance else "objects"] += triangles[key] > 0
        total["triangles"] += triangles[key]
        total["depth"] = max(total["depth"], depth(item.object))
    return total


def shape_key(thing: bpy.types.Object) -> str:
    """The same for objects that show the same evaluated mesh."""
    return str(thing.name if thing.modifiers else thing.data.name)


def triangle_count(mesh: bpy.types.Mesh) -> int:
    mesh.calc_loop_triangles()
    return len(mesh.loop_triangles)


def depth(thing: bpy.types.Object | None) -> int:
    return 0 if thing is None else 1 + depth(thing.parent)


def positions_at(frame: int) -> Numbers:
    """Numbers that say where all vertices and instances are at a frame; see `digest`.

    Evaluated meshes by object or, where shared, mesh name; object places under "objects" in the
    order of their names; places of instances, whose order means nothing, under "instances".
    """
    bpy.context.scene.frame_set(frame)
    found: Numbers = {}
    named: list[tuple[str, list[float]]] = []
    instanced: list[list[float]] = []
    for item in bpy.context.evaluated_depsgraph_get().object_instances:
        if item.object.type != "MESH":
            continue
        place = [value for row in item.matrix_world for value in row]
        if item.is_instance:
            instanced.append(place)
        else:
            named.append((item.object.name, place))
        key = shape_key(item.object)
        if key not in found:
            found[key] = digest(vertices_of(item.object.data))
    found["objects"] = digest(np.array([place for _, place in sorted(named)]))
    if instanced:
        found["instances"] = digest(np.sort(np.array(instanced), axis=0))
    return found


def vertices_of(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """Positions (V, 3), metres, object space."""
    flat = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def digest(rows: NDArray[Any]) -> list[float]:
    """The number of rows, then per column mean, spread, and a mean weighted by the row's number.

    The last one changes when rows change places.
    """
    if len(rows) == 0:
        return [0.0]
    values = rows.astype(np.float64)
    weights = np.sin(np.arange(len(rows)) * 0.7)[:, None]
    numbers = np.concatenate([values.mean(0), values.std(0), (values * weights).mean(0)])
    return [float(len(rows)), *(round(float(number), 7) for number in numbers)]


def main(words: list[str]) -> None:
    if words:
        Path(words[1]).write_text(json.dumps(measure(Path(words[0])), indent=1) + "\n")
        return
    scenes = {path.stem: measure(path) for path in sorted(FOLDER.glob("*.blend"))}
    (FOLDER / "measured.json").write_text(json.dumps(scenes, indent=1) + "\n")


if __name__ == "__main__":
    if "--background" in sys.argv or "-b" in sys.argv:
        main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    else:
        main(sys.argv[1:])
