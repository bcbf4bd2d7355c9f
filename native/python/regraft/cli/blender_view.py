"""A camera for a file that has none. Runs inside Blender: bpy is imported on use."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from regraft.camera import Camera
from regraft.cli.errors import InputError

GEOMETRY = frozenset(
    {"MESH", "CURVE", "CURVES", "SURFACE", "META", "FONT", "POINTCLOUD", "VOLUME", "GPENCIL"}
)
FOV_DEGREES = 40.0


def has_geometry(scene: Any) -> bool:
    """Whether any object of the scene, or of a collection it instances, may have a surface."""
    return any(_may_show(item) for item in scene.objects)


def frame_everything(scene: Any, aspect: float) -> None:
    """Gives the scene a camera that sees all that is visible at its first frame.

    Raises InputError if nothing is.
    """
    import bpy

    scene.frame_set(scene.frame_start)
    box = visible_bounds(bpy.context.evaluated_depsgraph_get())
    if box is None:
        raise InputError("no camera, and nothing visible that one could be placed for")
    view = Camera.framing(box, aspect, fov_degrees=FOV_DEGREES)
    scene.camera = _camera_object(scene, view)


def visible_bounds(depsgraph: Any) -> npt.NDArray[np.float64] | None:
    """(2,3) float64 world box round every instance that renders, or None if there is none.

    It is made of the objects' own boxes, so it may be larger than what it holds.
    """
    low, high = np.full(3, math.inf), np.full(3, -math.inf)
    for instance in depsgraph.object_instances:
        item = instance.object
        if not instance.show_self or item.type not in GEOMETRY or item.hide_render:
            continue
        corners = _box_corners(item, instance.matrix_world)
        if np.isfinite(corners).all():
            low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
    return np.stack([low, high]) if (low <= high).all() else None


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
