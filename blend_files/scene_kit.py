"""What every maker of an example scene needs: an empty scene, materials, meshes from arrays,
lights, a camera, saving.

Runs in Blender 3.4 only: a file saved by the oldest supported version opens in all of them.
World units are metres, Z is up, colours are linear RGB.
"""

import math
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

Triple = Sequence[float]
FOLDER = Path(__file__).resolve().parent


def new_scene(name: str, last_frame: int, sky: Triple) -> bpy.types.Scene:
    """Empties the file and gives its one scene: frames 1 to `last_frame`, 24 fps, 1280×720, view
    transform Standard.
    """
    if bpy.app.version[:2] != (3, 4):
        raise SystemExit(
            f"the example scenes are made with Blender 3.4, not {bpy.app.version_string}"
        )
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.name = name
    scene.frame_start, scene.frame_end = 1, last_frame
    scene.render.fps = 24
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    scene.view_settings.view_transform = "Standard"
    _set_engines(scene)
    _set_world(scene, sky)
    return scene


def _set_engines(scene: bpy.types.Scene) -> None:
    """Workbench with material colours; Cycles, if somebody chooses it, with one sample."""
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.render.engine = "BLENDER_WORKBENCH"
    shading = scene.display.shading
    shading.light, shading.color_type, shading.background_type = "STUDIO", "MATERIAL", "WORLD"


def _set_world(scene: bpy.types.Scene, sky: Triple) -> None:
    world = bpy.data.worlds.new("World")
    world.color = sky
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*sky, 1)
    scene.world = world


def material(
    name: str,
    color: Triple,
    *,
    roughness: float = 0.7,
    metallic: float = 0.0,
    emission: float = 0.0,
) -> bpy.types.Material:
    """A material whose viewport colour and base colour agree; `emission` is the strength of glowing
    in that colour.
    """
    made = bpy.data.materials.new(name)
    made.diffuse_color = (*color, 1)
    made.roughness, made.metallic = roughness, metallic
    made.use_nodes = True
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*color, 1)
    inputs["Roughness"].default_value = roughness
    inputs["Metallic"].default_value = metallic
    if emission:
        inputs["Emission"].default_value = (*color, 1)
        inputs["Emission Strength"].default_value = emission
    return made


def quantised(values: NDArray[Any], step: float) -> NDArray[np.float32]:
    """Rounds to multiples of `step` (a power of two), so that the saved file packs well; same
    shape, float32.
    """
    rounded: NDArray[np.float32] = (np.round(values / step) * step).astype(np.float32)
    return rounded


def mesh_from_arrays(
    name: str,
    vertices: NDArray[Any],
    faces: NDArray[Any],
    materials: Sequence[bpy.types.Material] = (),
    *,
    sizes: NDArray[Any] | None = None,
) -> bpy.types.Mesh:
    """A mesh from vertices (V, 3) in metres and faces (F, 3) or (F, 4); edges in ascending order,
    which packs well.

    With `sizes` (F,) the faces are polygons of so many corners each and `faces` is the flat list of
    their vertices.
    """
    if sizes is None:
        sizes = np.full(len(faces), faces.shape[1])
    corners = faces.ravel()
    edges, edge_of_corner, starts = _edges(corners, sizes)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.edges.add(len(edges))
    mesh.edges.foreach_set("vertices", edges.astype(np.int32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.loops.foreach_set("edge_index", edge_of_corner.astype(np.int32))
    mesh.polygons.add(len(sizes))
    mesh.polygons.foreach_set("loop_start", starts.astype(np.int32))
    mesh.polygons.foreach_set("loop_total", sizes.astype(np.int32))
    for slot in materials:
        mesh.materials.append(slot)
    mesh.update()
    if mesh.validate():
        raise ValueError(f"{name}: faces or edges are not valid")
    return mesh


def _edges(
    corners: NDArray[Any], sizes: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """The edges (E, 2) of polygons, the edge that starts at each corner, and each polygon's first
    corner.
    """
    starts = np.cumsum(sizes) - sizes
    following = np.arange(1, len(corners) + 1)
    following[starts + sizes - 1] = starts
    pairs = np.sort(np.stack([corners, corners[following]], axis=1), axis=1)
    edges, edge_of_corner = np.unique(pairs, axis=0, return_inverse=True)
    return edges, edge_of_corner.ravel(), starts


def set_attribute(mesh: bpy.types.Mesh, name: str, values: NDArray[Any]) -> None:
    """Stores a point attribute: (V, 3) vectors, (V,) integers or floats."""
    whole = np.issubdtype(values.dtype, np.integer)
    kind = "FLOAT_VECTOR" if values.ndim == 2 else "INT" if whole else "FLOAT"
    layer = mesh.attributes.new(name, kind, "POINT")
    packed = np.ascontiguousarray(values, np.int32 if whole else np.float32)
    layer.data.foreach_set("vector" if values.ndim == 2 else "value", packed.ravel())


def shade_smooth(mesh: bpy.types.Mesh) -> None:
    """Shades every face smooth."""
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))


def collection(name: str, parent: bpy.types.Collection | None = None) -> bpy.types.Collection:
    """A new collection under `parent`, or under the scene's own."""
    made = bpy.data.collections.new(name)
    (parent or bpy.context.scene.collection).children.link(made)
    return made


def source_collection() -> bpy.types.Collection:
    """A hidden collection for objects only geometry nodes read: evaluated once, never drawn."""
    made = collection("Sources")
    made.hide_viewport = made.hide_render = True
    return made


def add_object(
    name: str,
    data: bpy.types.ID | None,
    *,
    location: Triple = (0, 0, 0),
    rotation: Triple = (0, 0, 0),
    parent: bpy.types.Object | None = None,
    into: bpy.types.Collection | None = None,
) -> bpy.types.Object:
    """An object in a collection (the scene's own by default); location and Euler rotation (radians)
    in its parent's frame.
    """
    made = bpy.data.objects.new(name, data)
    made.location, made.rotation_euler = location, rotation
    made.parent = parent
    (into or bpy.context.scene.collection).objects.link(made)
    return made


def aim(thing: bpy.types.Object, target: Triple) -> bpy.types.Object:
    """Turns a camera or lamp towards a point."""
    towards = Vector(target) - thing.location
    thing.rotation_euler = towards.to_track_quat("-Z", "Y").to_euler()
    return thing


def add_camera(name: str, location: Triple, target: Triple, lens: float = 35) -> bpy.types.Object:
    """A camera looking at `target`, made the scene's active one; `lens` in millimetres on a 36 mm
    sensor.
    """
    camera = bpy.data.cameras.new(name)
    camera.lens = lens
    camera.clip_end = 2000
    made = aim(add_object(name, camera, location=location), target)
    bpy.context.scene.camera = made
    return made


def add_light(
    kind: str,
    name: str,
    location: Triple,
    target: Triple,
    energy: float,
    color: Triple = (1, 1, 1),
    size: float = 0.1,
) -> bpy.types.Object:
    """A lamp: `kind` SUN (energy in W/m², size in radians), POINT or AREA (watts, metres)."""
    light = bpy.data.lights.new(name, kind)
    light.energy, light.color = energy, color
    setattr(light, {"SUN": "angle", "POINT": "shadow_soft_size", "AREA": "size"}[kind], size)
    return aim(add_object(name, light, location=location), target)


def animate(
    owner: bpy.types.ID,
    path: str,
    keys: Sequence[tuple[float, float]],
    index: int = -1,
    kind: str = "LINEAR",
) -> None:
    """Writes an F-curve of (frame, value) keys onto `owner`, all with one interpolation."""
    if owner.animation_data is None:
        owner.animation_data_create()
    data = owner.animation_data
    if data.action is None:
        data.action = bpy.data.actions.new(f"{owner.name} action")
    curve = data.action.fcurves.new(path, index=max(index, 0))
    curve.keyframe_points.add(len(keys))
    curve.keyframe_points.foreach_set("co", np.array(keys, np.float32).ravel())
    for point in curve.keyframe_points:
        point.interpolation = kind
    curve.update()


def animate_by_samples(owner: bpy.types.ID, path: str, values: NDArray[Any]) -> None:
    """Writes values (frames, axes) from frame 1 on as F-curves of plain samples, one a frame: small
    and exact.
    """
    frames = np.arange(1, len(values) + 1)
    for axis in range(values.shape[1]):
        animate(owner, path, list(zip(frames, values[:, axis], strict=True)), index=axis)
    for curve in owner.animation_data.action.fcurves:
        curve.convert_to_samples(1, len(values) + 1)


def ground(radius: float, color: Triple, name: str = "Ground") -> bpy.types.Object:
    """A flat disc of `radius` metres at height zero."""
    angles = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    rim = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) * radius
    plain = material(name, color, roughness=0.95)
    return add_object(name, mesh_from_arrays(name, rim, np.arange(64)[None, :], [plain]))


def fibonacci_sphere(count: int) -> NDArray[np.float64]:
    """(count, 3) unit vectors spread evenly over the sphere."""
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = np.arange(count) * math.pi * (3 - math.sqrt(5))
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)


def save(name: str) -> None:
    """Writes `<name>.blend`, compressed, beside the makers or into the folder named after `--`."""
    bpy.context.scene.frame_set(1)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    path = Path(words[0] if words else FOLDER).resolve() / f"{name}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)
    _pack_tighter(path)
    print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")


def _pack_tighter(path: Path) -> None:
    """Compresses the file again at a higher level, a fifth to a third smaller, where the zstd tool
    is installed.
    """
    tool = shutil.which("zstd")
    if tool is None:
        return
    plain = subprocess.run([tool, "-d", "-c", str(path)], check=True, capture_output=True).stdout
    packed = subprocess.run(
        [tool, "-19", "-c"], input=plain, check=True, capture_output=True
    ).stdout
    path.write_bytes(packed)
