"""Runs inside a Blender: FOLDER. Writes the small scenes that the command is tested on."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[1])


def empty_scene() -> bpy.types.Scene:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 6
    scene.render.resolution_x, scene.render.resolution_y = 160, 90
    return scene


def add_object(data: bpy.types.ID | None, name: str) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


def add_camera() -> None:
    camera = add_object(bpy.data.cameras.new("camera"), "camera")
    camera.location, camera.rotation_euler = (0, -12, 0), (1.5707963, 0, 0)
    bpy.context.scene.camera = camera


def save(name: str) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / name))


def moving() -> None:
    """A cube that crosses the picture from left to right in front of a still one."""
    empty_scene()
    add_camera()
    bpy.ops.mesh.primitive_cube_add(location=(0, 4, 0))
    bpy.ops.mesh.primitive_cube_add()
    mover = bpy.context.object
    for frame, x in ((1, -4), (6, 4)):
        mover.location.x = x
        mover.keyframe_insert("location", frame=frame)
    save("moving.blend")


def without_camera() -> None:
    empty_scene()
    bpy.ops.mesh.primitive_monkey_add(location=(100, 50, -20))
    save("no_camera.blend")


def idle_camera() -> None:
    """A camera that sees the cube, but is not the active one."""
    scene = empty_scene()
    add_camera()
    scene.camera = None
    bpy.ops.mesh.primitive_cube_add()
    save("idle_camera.blend")


def without_geometry() -> None:
    empty_scene()
    add_camera()
    save("no_geometry.blend")


def simulated() -> None:
    """A cloth that falls, with nothing baked."""
    scene = empty_scene()
    scene.frame_end = 12
    add_camera()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, location=(0, 0, 2))
    bpy.ops.object.modifier_add(type="CLOTH")
    save("simulated.blend")


moving()
without_camera()
idle_camera()
without_geometry()
simulated()
