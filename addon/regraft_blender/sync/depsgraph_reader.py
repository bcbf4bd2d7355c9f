"""Reads what changed in an evaluated dependency graph since it was last read.

Three grades of effort. Nothing flagged: nothing is read. Objects moved or deformed: matrices in
bulk, and only the meshes concerned. Objects may have come, gone or changed their nature: the whole
list is walked once (about 2 µs an instance), and still only the meshes concerned are read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from .. import compat
from .delta import SceneDelta
from .instance_table import InstanceTable, Keys, Matrices, as_transforms
from .light_reader import placed
from .material_reader import read_world
from .mesh_library import Reads
from .object_list import ObjectList, Walk
from .updates import Updates, read_updates

Flags = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Listing:
    """Blender's list of N instances in bulk: `matrices` (N,16), and `names` (N,) that tell
    instances by one instancer apart."""

    matrices: Matrices
    names: Flags

    @property
    def nbytes(self) -> int:
        """Of both."""
        return self.matrices.nbytes + self.names.nbytes

    def lists_the_same(self, other: Listing) -> bool:
        """True if both hold the same instances in the same order, wherever they stand; given that
        no object came, went or was hidden."""
        return np.array_equal(self.names, other.names)


class DepsgraphReader:
    """Turns one dependency graph, read again and again, into deltas."""

    def __init__(self) -> None:
        self.table = InstanceTable()
        self.objects = ObjectList()
        # Leaves the scene's lights out, so that the library's headlight shines.
        self.headlight = False
        self._graph = 0
        self._flags = np.empty(0, np.int32)
        self._listing: Listing | None = None
        self._is_listed = False
        self._lights: tuple[Any, ...] | None = None
        self._world: tuple[float, float, float] | None = None

    def read(
        self,
        depsgraph: bpy.types.Depsgraph,
        *,
        view: bpy.types.SpaceView3D | None = None,
        everything: bool = False,
    ) -> SceneDelta:
        """What changed. `view` leaves out what that viewport hides; `everything` says that
        Blender's updates are not known to be complete, so that all is looked at again."""
        delta = SceneDelta()
        graph, everything = depsgraph.as_pointer(), everything or self._graph == 0
        everything = everything or graph != self._graph
        # Should this reading fail half way, the next one must not trust what it left.
        self._graph = 0
        self.objects.meshes.reads = Reads()
        updates = read_updates(depsgraph)
        self.objects.meshes.invalidate(None if everything else updates.geometry)
        for material in updates.materials:
            self.objects.materials.refresh(material)
        for light in updates.lights:
            self.objects.read_light(light)
        self._read_instances(depsgraph, updates, view, everything, delta)
        self._read_surroundings(depsgraph, delta)
        delta.groups = self.objects.hierarchy.take_new()
        delta.materials = self.objects.materials.take_table()
        self._describe(delta)
        self._graph = graph
        return delta

    def _read_instances(
        self,
        depsgraph: bpy.types.Depsgraph,
        updates: Updates,
        view: bpy.types.SpaceView3D | None,
        everything: bool,
        delta: SceneDelta,
    ) -> None:
        flags, old_flags = _object_flags(depsgraph), self._flags
        self._flags, self._is_listed = flags, False
        is_same = not everything and np.array_equal(flags, old_flags)
        if is_same and updates.is_empty:
            return
        listing, old = _read_listing(depsgraph), self._listing
        self._listing, self._is_listed = listing, True
        is_same = is_same and old is not None and listing.lists_the_same(old)
        if is_same and not updates.is_structural and self._reads_alone(updates, delta):
            self.table.move(listing.matrices, delta)
        else:
            self._walk(depsgraph, listing, view, delta)

    def _reads_alone(self, updates: Updates, delta: SceneDelta) -> bool:
        """Read the objects that changed one by one, unless that cannot be enough."""
        if updates.is_scene and not self.objects.knows_all(updates.objects):
            return False
        return self.objects.read_deformed(updates, delta)

    def _walk(
        self,
        depsgraph: bpy.types.Depsgraph,
        listing: Listing,
        view: bpy.types.SpaceView3D | None,
        delta: SceneDelta,
    ) -> None:
        walk = Walk(self.objects, depsgraph, view, delta)
        rows = walk.rows(listing.matrices)
        scene = depsgraph.scene.original

        def exists(owners: Keys) -> npt.NDArray[np.bool_]:
            if not len(owners):
                return np.empty(0, np.bool_)
            return np.isin(owners, np.array([ob.as_pointer() for ob in scene.objects], np.uint64))

        self.table.update(rows, self.objects.material_sets, exists, delta)
        self.objects.meshes.drop_unused(self.table.used_meshes(), delta)

    def _read_surroundings(self, depsgraph: bpy.types.Depsgraph, delta: SceneDelta) -> None:
        """Lights and world: few values, compared instead of tracked."""
        world = read_world(depsgraph.scene.world)
        if world != self._world:
            delta.world = self._world = world
        if self._listing is None:
            return
        lights = () if self.headlight else self._placed_lights(self._listing.matrices)
        if lights != self._lights:
            delta.lights = self._lights = lights

    def _placed_lights(self, matrices: Matrices) -> tuple[Any, ...]:
        make, settings = compat.native().Light, self.objects.light_settings
        return tuple(
            make(**placed(settings[address], as_transforms(matrices[[position]])[0]))
            for position, address in self.objects.lights
        )

    def _describe(self, delta: SceneDelta) -> None:
        """Say in words what was not needed."""
        meshes, total = self.objects.meshes, len(self.table.rows)
        touched = [*delta.added_meshes, *delta.retopologised, *delta.deformed]
        is_changed = np.isin(self.table.rows.meshes, touched)
        is_changed |= np.isin(self.table.handles, delta.moved)
        if delta.added is not None:
            is_changed |= np.isin(self.table.handles, delta.added.handles)
        unchanged = total - int(is_changed.sum())
        if unchanged:
            delta.left_out.append(f"{unchanged} of {total} objects unchanged: not read")
        unread, of_all = self._unread_bytes()
        if unread:
            delta.left_out.append(f"{unread:,} of {of_all:,} bytes of geometry not read")
        if meshes.reads.unchanged:
            delta.left_out.append(f"{meshes.reads.unchanged} meshes read but unchanged: no refit")
        warnings, remarks = self.objects.notices.take()
        delta.warnings += warnings
        delta.left_out += remarks

    def _unread_bytes(self) -> tuple[int, int]:
        """Of meshes and matrices, this time; and what there is of both."""
        meshes = self.objects.meshes
        listed = 0 if self._listing is None else self._listing.nbytes
        read = meshes.reads.bytes + (listed if self._is_listed else 0)
        of_all = meshes.bytes() + listed
        return max(0, of_all - read), of_all


def _object_flags(depsgraph: bpy.types.Depsgraph) -> Flags:
    """(2,O) visibility and pass index of the view layer's objects: Blender flags neither."""
    objects = depsgraph.view_layer_eval.objects
    flags = np.empty((2, len(objects)), np.int32)
    hides = np.empty(len(objects), np.bool_)
    objects.foreach_get("hide_render" if depsgraph.mode == "RENDER" else "hide_viewport", hides)
    flags[0] = hides
    objects.foreach_get("pass_index", flags[1])
    return flags


def _read_listing(depsgraph: bpy.types.Depsgraph) -> Listing:
    instances = depsgraph.object_instances
    count = len(instances)
    matrices = np.empty(count * 16, np.float32)
    names = np.empty(count, np.int32)
    instances.foreach_get("matrix_world", matrices)
    instances.foreach_get("random_id", names)
    return Listing(matrices.reshape(-1, 16), names)
