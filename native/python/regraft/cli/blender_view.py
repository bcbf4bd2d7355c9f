"""A camera for a file that has none. Runs inside Blender: bpy is imported on use."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from regraft.camera import Camera, frame_points
from regraft.cli.errors import InputError

GEOMETRY = frozenset(
    {"MESH", "CURVE", "CURVES", "SURFACE", "META", "FONT", "POINTCLOUD", "VOLUME", "GPENCIL"}
)
FOV_DEGREES = 40.0


def has_geometry(scene: Any) -> bool:
    """Whether any object of the scene, or of a collection it instances, may have a surface."""
    return any(_may_show(item) for item in scene.objects)


def ensure_camera(scene: Any, aspect: float) -> list[str]:
    """Sees to it that the scene has a camera; returns a note of what was decided, if anything.

    The scene's own wins, then the first camera in it by name (importers may leave none active),
    then one that frames everything. Raises InputError if nothing is visible to be framed.
    """
    if scene.camera is not None:
        return []
    cameras = sorted((o for o in scene.objects if o.type == "CAMERA"), key=lambda o: str(o.name))
    if cameras:
        scene.camera = cameras[0]
        return [f"no camera is active in the file: taking {cameras[0].name!r}"]
    frame_everything(scene, aspect)
    return ["no camera in the file: framing everything from a three-quarter view"]


def frame_everything(scene: Any, aspect: float) -> None:
    """Gives the scene a camera that sees all that is visible at its first frame.

    Raises InputError if nothing is.
    """
    import bpy

    scene.frame_set(scene.frame_start)
    corners = visible_corners(bpy.context.evaluated_depsgraph_get())
    if not len(corners):
        raise InputError("no camera, and nothing visible that one could be placed for")
    view = frame_points(corners, aspect, fov_degrees=FOV_DEGREES)
    scene.camera = _camera_object(scene, view)


def visible_corners(depsgraph: Any) -> npt.NDArray[np.float64]:
    """(N,3) float64, world frame: the corners of the boxes of all instances that render."""
    boxes = [
        _box_corners(instance.object, instance.matrix_world)
        for instance in depsgraph.object_instances
        if instance.show_self
        and instance.object.type in GEOMETRY
        and not instance.object.hide_render
    ]
    finite = [box for box in boxes if np.isfinite(box).all()]
    return np.concatenate(finite) if finite else np.empty((0, 3))


def _box_corners(item: Any, matrix_world: Any) -> npt.NDArray[np.float64]:
    matrix = np.array(matrix_world, np.float64)
    local = np.array([tuple(corner) for corner in item.bound_box], np.float64)
    return np.asarray(local @ matrix[:3, :3].T + matrix[:3, 3])


def _may_show(item: Any) -> bool:
    if item.type in GEOMETRY:
        return True
    collection = item.instance_collection if item.instance_type == "COLLECTION" else None
    return collection is not None and any(o.type in GEOMETRY for o in collection.all_objects)


def _camera_object(scene: Any, view: Camera) -> Any:
    import bpy
    from mathutils import Matrix

    data = bpy.data.cameras.new("regraft framing")
    data.sensor_fit = "AUTO"
    data.angle = math.radians(FOV_DEGREES)
    data.clip_start, data.clip_end = view.clip_near, view.clip_far
    camera = bpy.data.objects.new("regraft framing", data)
    camera.matrix_world = Matrix(view.matrix.tolist())
    scene.collection.objects.link(camera)
    return camera
