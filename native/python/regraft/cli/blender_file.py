"""Opens a file in Blender, whatever its format. Runs inside Blender: bpy is imported on use."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy

from regraft.cli.blender_engine import report_words
from regraft.cli.errors import InputError

# Ending: add-on to enable first, operators to try in turn, arguments.
Importer = tuple[str, tuple[str, ...], dict[str, Any]]
IMPORTERS: dict[str, Importer] = {
    ".glb": ("io_scene_gltf2", ("import_scene.gltf",), {}),
    ".gltf": ("io_scene_gltf2", ("import_scene.gltf",), {}),
    ".usd": ("", ("wm.usd_import",), {"set_frame_range": True}),
    ".usda": ("", ("wm.usd_import",), {"set_frame_range": True}),
    ".usdc": ("", ("wm.usd_import",), {"set_frame_range": True}),
    ".usdz": ("", ("wm.usd_import",), {"set_frame_range": True}),
    ".abc": ("", ("wm.alembic_import",), {"set_frame_range": True, "as_background_job": False}),
    ".obj": ("", ("wm.obj_import",), {}),
    ".ply": ("io_mesh_ply", ("wm.ply_import", "import_mesh.ply"), {}),
    ".stl": ("io_mesh_stl", ("wm.stl_import", "import_mesh.stl"), {}),
}
SUFFIXES = (".blend", *IMPORTERS)

# A grey sky for files that bring none, so that shadows are not black.
DEFAULT_WORLD = (0.05, 0.05, 0.05)
DEFAULT_SIZE = (1280, 720)


def open_file(source: Path) -> list[str]:
    """Makes `source` the file that is open in Blender; returns notes for the user.

    Raises InputError naming the file and the cause.
    """
    if source.suffix.lower() == ".blend":
        _open_blend(source)
        return _missing_libraries()
    _import(source)
    return []


def find_importer(suffix: str) -> Callable[..., Any] | None:
    """This Blender's operator for files with that ending, or None."""
    import bpy

    addon, names, _ = IMPORTERS[suffix]
    if addon:
        _enable(addon)
    for name in names:
        group, operator = name.split(".")
        if operator in dir(getattr(bpy.ops, group)):
            found: Callable[..., Any] = getattr(getattr(bpy.ops, group), operator)
            return found
    return None


def _open_blend(source: Path) -> None:
    import bpy

    try:
        bpy.ops.wm.open_mainfile(filepath=str(source), use_scripts=False)
    except RuntimeError as error:
        raise InputError(f"Blender cannot open {source}: {report_words(error)}") from error


def _missing_libraries() -> list[str]:
    import bpy

    paths = [bpy.path.abspath(library.filepath) for library in bpy.data.libraries]
    return [
        f"linked library {p} is missing: what it holds is not shown"
        for p in paths
        if not os.path.exists(p)
    ]


def _import(source: Path) -> None:
    import bpy

    operator = find_importer(source.suffix.lower())
    if operator is None:
        raise InputError(
            f"Blender {bpy.app.version_string} as installed here has no importer for "
            f"{source.suffix} files: cannot read {source}"
        )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    _prepare_empty_scene()
    arguments = IMPORTERS[source.suffix.lower()][2]
    try:
        with _numpy_as_of_old():
            result = operator(filepath=str(source), **arguments)
    except RuntimeError as error:
        raise InputError(f"Blender cannot import {source}: {report_words(error)}") from error
    if "FINISHED" not in result or not bpy.data.objects:
        raise InputError(f"Blender found nothing it can read in {source}")
    _set_frame_range()


def _prepare_empty_scene() -> None:
    import bpy

    scene = bpy.context.scene
    scene.frame_start = scene.frame_end = scene.frame_current = 1
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = DEFAULT_SIZE
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = DEFAULT_WORLD


def _set_frame_range() -> None:
    """Widens a range the importer left at one frame to the keys of the actions in use."""
    import bpy

    scene = bpy.context.scene
    if scene.frame_end > scene.frame_start:
        return
    ranges = [action.frame_range for action in bpy.data.actions if action.users]
    if ranges:
        scene.frame_start = int(min(first for first, _ in ranges))
        scene.frame_end = max(scene.frame_start, round(max(last for _, last in ranges)))


@contextmanager
def _numpy_as_of_old() -> Iterator[None]:
    """Blender 3.4's glTF importer says `numpy.bool`, which NumPy 1.24 to 1.26 lack."""
    missing = "bool" not in vars(numpy)
    if missing:
        setattr(numpy, "bool", bool)  # noqa: B010
    try:
        yield
    finally:
        if missing:
            delattr(numpy, "bool")


def _enable(addon: str) -> None:
    import addon_utils

    addon_utils.enable(addon, default_set=False)
