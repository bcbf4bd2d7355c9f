"""What Blender says has changed since a dependency graph was last read."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np


@dataclass
class Updates:
    """One reading of `depsgraph.updates`. Addresses are of original data-blocks; the lists hold
    evaluated ones, valid within the frame's callback only.

    `is_structural`: a collection changed, so that objects may have come or gone. `is_scene`: the
    scene itself is flagged, which many files are in every frame; objects that came with it are
    flagged too. `is_empty`: nothing else is, but for cameras, which are read apart.
    """

    is_empty: bool = True
    is_structural: bool = False
    is_scene: bool = False
    geometry: set[int] = field(default_factory=set)
    objects: list[bpy.types.Object] = field(default_factory=list)
    materials: list[bpy.types.Material] = field(default_factory=list)
    lights: list[bpy.types.Light] = field(default_factory=list)


def read_updates(depsgraph: bpy.types.Depsgraph) -> Updates:
    """Sort the updates by what has to be read again.

    `objects` are those whose geometry changed or that changed in something other than their
    transform. Objects that only moved are not looked at one by one: their matrices are read in
    bulk, and a scene may have thousands.
    """
    entries = depsgraph.updates
    count = len(entries)
    updates = Updates()
    geometry, transform = np.empty(count, np.bool_), np.empty(count, np.bool_)
    entries.foreach_get("is_updated_geometry", geometry)
    entries.foreach_get("is_updated_transform", transform)
    wanted = geometry | ~transform
    for entry, is_wanted, is_geometry in zip(
        entries, wanted.tolist(), geometry.tolist(), strict=True
    ):
        if is_wanted:
            _sort_in(updates, entry.id, is_geometry)
        elif updates.is_empty:
            updates.is_empty = _is_camera(entry.id)
    return updates


def _is_camera(block: bpy.types.ID) -> bool:
    """Whether it shows nothing, wherever it is."""
    return isinstance(block, bpy.types.Object) and block.type == "CAMERA"


def _sort_in(updates: Updates, block: bpy.types.ID, is_geometry: bool) -> None:
    if isinstance(block, bpy.types.Scene):
        updates.is_scene = True
        return
    # What an action moves is flagged itself.
    if isinstance(block, bpy.types.Action | bpy.types.Camera):
        return
    updates.is_empty = False
    if isinstance(block, bpy.types.Material):
        updates.materials.append(block)
    elif isinstance(block, bpy.types.Light):
        updates.lights.append(block)
    elif isinstance(block, bpy.types.Collection):
        updates.is_structural = True
    elif isinstance(block, bpy.types.Object):
        updates.objects.append(block)
    if is_geometry:
        updates.geometry.add(block.original.as_pointer())
