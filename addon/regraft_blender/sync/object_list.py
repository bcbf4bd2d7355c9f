"""Walks Blender's list of instances and finds out what each of them shows."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import bpy
import numpy as np

from .delta import NONE, SceneDelta
from .hierarchy import Hierarchy
from .instance_table import Keys, Matrices, Rows, made_unique, mixed
from .light_reader import LightSettings, read_light
from .material_reader import Materials, materials_of
from .mesh_library import MeshLibrary
from .notices import Notices
from .updates import Updates

MAX_INSTANCES = 2_000_000
# Blender cuts infinite coordinates off at the largest float; nothing real is beyond this.
FARTHEST = 1e30
GEOMETRY = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
NO_MESH = NONE


@dataclass(frozen=True)
class Source:
    """What all instances of one object share that the same instancer brings in with the same mesh.

    `seed` starts their keys; `mesh`, `group` and `materials` are handles, `owner` the address of
    the original object whose removal removes them, `light` that of the original light or 0.
    `instancer_flags` are the object's own, which tell whether an instancer shows itself.
    """

    seed: int
    owner: int
    mesh: int = NO_MESH
    materials: int = 0
    group: int = NONE
    object_index: int = 0
    light: int = 0
    instancer_flags: tuple[bool, ...] = ()


class ObjectList:
    """What is known of a scene's objects from one reading to the next."""

    def __init__(self) -> None:
        self.meshes = MeshLibrary()
        self.materials = Materials()
        self.hierarchy = Hierarchy()
        self.notices = Notices()
        self.material_sets: list[tuple[int, ...]] = []
        # Settings by address of the original light, and where in Blender's list each stands.
        self.light_settings: dict[int, LightSettings] = {}
        self.lights: list[tuple[int, int]] = []
        # By address of the original object: its own source, or None if others show it too, share
        # its mesh, or if it brings in instances of geometry that it made itself.
        self.known: dict[int, Source | None] = {}
        self._set_indices: dict[tuple[int, ...], int] = {}

    def knows_all(self, objects: list[bpy.types.Object]) -> bool:
        """True if each that may be seen was there when the list was last walked."""
        return all(ob.original.as_pointer() in self.known or not _may_show(ob) for ob in objects)

    def read_deformed(self, updates: Updates, delta: SceneDelta) -> bool:
        """Read the objects that changed, if all of them are still what they were. If not, return
        False: the whole list has to be walked."""
        is_complete = all(
            self._read_alone(ob, ob.original.as_pointer() in updates.geometry, delta)
            for ob in updates.objects
        )
        return is_complete and not delta.retopologised

    def material_set(self, ob: bpy.types.Object, mesh: bpy.types.Mesh, slot_count: int) -> int:
        """Index in `material_sets` of the materials `ob` shows `mesh` with, at least one a slot."""
        handles = [self.materials.handle(material) for material in materials_of(ob, mesh)] or [0]
        # As Blender does, a slot beyond the last shows the last one.
        handles += handles[-1:] * (slot_count - len(handles))
        key = tuple(handles)
        if key not in self._set_indices:
            self._set_indices[key] = len(self.material_sets)
            self.material_sets.append(key)
        return self._set_indices[key]

    def read_light(self, light: bpy.types.Light) -> int:
        """Read an evaluated light; the address it is known by."""
        address = int(light.original.as_pointer())
        self.light_settings[address] = read_light(light)
        return address

    def _read_alone(self, ob: bpy.types.Object, is_geometry: bool, delta: SceneDelta) -> bool:
        address = ob.original.as_pointer()
        if address not in self.known:
            return True
        source = self.known[address]
        if source is None or source.instancer_flags != _instancer_flags(ob):
            return False
        if source.mesh == NO_MESH:
            return not (is_geometry and _may_show(ob))
        mesh = ob.data
        if not _has_faces(mesh) or source.mesh not in self.meshes:
            return False
        record = self.meshes[source.mesh]
        if self.material_set(ob, mesh, record.slot_count) != source.materials:
            return False
        if is_geometry:
            record.address = mesh.as_pointer()
            self.meshes.read(record, ob, mesh, delta)
        return True


class Walk:
    """One pass over Blender's list; every Blender object it meets is let go when it ends."""

    def __init__(
        self,
        objects: ObjectList,
        depsgraph: bpy.types.Depsgraph,
        view: bpy.types.SpaceView3D | None,
        delta: SceneDelta,
    ) -> None:
        self.objects = objects
        self.depsgraph = depsgraph
        self.view = view
        self.delta = delta
        self.sources: list[Source] = []
        self._meshes: dict[int, int] = {}
        self._taken: set[tuple[object, ...]] = set()
        self._users: dict[int, set[int]] = {}
        self._own: dict[int, int] = {}
        self._shown_by_others: set[int] = set()

    def rows(self, matrices: Matrices) -> Rows:
        """The instances that have geometry, given all instances' matrices (N,16). Meshes that
        changed are read on the way."""
        shown = np.empty(len(matrices), np.bool_)
        self.depsgraph.object_instances.foreach_get("show_self", shown)
        self.objects.hierarchy.open(self.depsgraph.scene.original)
        index = self._walk(shown.tolist())
        self.objects.hierarchy.close()
        self._remember(index)
        count = len(index)
        near = (np.abs(matrices[:count]) < FARTHEST).all(axis=1)
        if not near.all():
            self.objects.notices.warn("instances whose matrix is not finite are not drawn")
        meshes = self._gather("mesh", np.uint32)[index]
        positions = np.flatnonzero((meshes != NO_MESH) & shown[:count] & near)
        return self._rows(positions, index[positions], matrices[positions])

    def _rows(self, positions: np.ndarray, index: np.ndarray, matrices: Matrices) -> Rows:
        return Rows(
            keys=self._keys(positions, index),
            positions=positions,
            meshes=self._gather("mesh", np.uint32)[index],
            matrices=matrices,
            materials=self._gather("materials", np.int64)[index],
            groups=self._gather("group", np.uint32)[index],
            object_indices=self._gather("object_index", np.uint32)[index],
            owners=self._gather("owner", np.uint64)[index],
        )

    def _gather(self, name: str, kind: type) -> np.ndarray:
        return np.array([getattr(source, name) for source in self.sources], kind)

    def _keys(self, positions: np.ndarray, index: np.ndarray) -> Keys:
        instances = self.depsgraph.object_instances
        words = np.empty(len(instances) * 8, np.int32)
        instances.foreach_get("persistent_id", words)
        seeds = self._gather("seed", np.uint64)[index]
        return made_unique(mixed(seeds, words.reshape(-1, 8)[positions]))

    def _walk(self, shown: list[bool]) -> np.ndarray:
        """(N,) the source of each instance; the loop that runs once an instance."""
        seen: dict[tuple[int, ...], int] = {}
        index: list[int] = []
        listed = zip(islice(self.depsgraph.object_instances, MAX_INSTANCES), shown, strict=False)
        for instance, is_shown in listed:
            key: tuple[int, ...]
            if instance.is_instance:
                data = instance.object.data
                key = (
                    instance.instance_object.as_pointer(),
                    instance.parent.as_pointer(),
                    data.as_pointer() if data else 0,
                    is_shown,
                )
            else:
                key = (instance.object.as_pointer(), is_shown)
            number = seen.get(key)
            if number is None:
                number = seen[key] = len(self.sources)
                self.sources.append(self._source(instance, is_shown))
            index.append(number)
        if len(index) == MAX_INSTANCES:
            self.objects.notices.warn(f"only the first {MAX_INSTANCES:,} instances are drawn")
        return np.array(index, np.int64)

    def _source(self, instance: bpy.types.DepsgraphObjectInstance, is_shown: bool) -> Source:
        ob = instance.instance_object if instance.is_instance else instance.object
        original = ob.original
        owner, seed = original.as_pointer(), original.as_pointer()
        group = self.objects.hierarchy.group_of(original)
        if instance.is_instance:
            parent = instance.parent.original
            owner = parent.as_pointer()
            seed = (seed * 0x9E3779B97F4A7C15 + owner) & 0xFFFFFFFFFFFFFFFF
            group = self.objects.hierarchy.group_under(parent)
            self._shown_by_others.add(original.as_pointer())
        else:
            self._own[owner] = len(self.sources)
        flags = _instancer_flags(ob)
        if ob.type == "LIGHT":
            light = self.objects.read_light(ob.data)
            return Source(seed, owner, light=light, instancer_flags=flags)
        mesh = instance.object.data
        if not is_shown or not self._draws(ob, instance, mesh):
            return Source(seed, owner, instancer_flags=flags)
        handle = self._mesh_handle(ob, instance, mesh)
        slots = self.objects.meshes[handle].slot_count
        materials = self.objects.material_set(ob, mesh, slots)
        index = max(0, ob.pass_index)
        return Source(seed, owner, handle, materials, group, index, instancer_flags=flags)

    def _draws(
        self,
        ob: bpy.types.Object,
        instance: bpy.types.DepsgraphObjectInstance,
        mesh: bpy.types.ID | None,
    ) -> bool:
        """True if the instance has triangles and the user wants to see it."""
        self.objects.notices.look_at(ob, self.depsgraph.view_layer)
        if not _has_faces(mesh):
            return False
        bringer = instance.parent if instance.is_instance else ob
        if self.view is not None and not bringer.visible_in_viewport_get(self.view):
            return False
        return not ob.original.indirect_only_get(view_layer=self.depsgraph.view_layer)

    def _mesh_handle(
        self,
        ob: bpy.types.Object,
        instance: bpy.types.DepsgraphObjectInstance,
        mesh: bpy.types.Mesh,
    ) -> int:
        """Handle of the evaluated `mesh`, read if need be; instances that share it share it."""
        address, owner = mesh.as_pointer(), ob.original.as_pointer()
        handle = self._meshes.get(address)
        if handle is None:
            key = self._mesh_key(ob, instance, mesh)
            record = self.objects.meshes.record(key, address)
            self.objects.meshes.read(record, ob, mesh, self.delta)
            handle = self._meshes[address] = record.handle
        self.objects.meshes.link(handle, owner)
        if ob.original.data is not None:
            self.objects.meshes.link(handle, ob.original.data.as_pointer())
        self._users.setdefault(handle, set()).add(owner)
        return handle

    def _mesh_key(
        self,
        ob: bpy.types.Object,
        instance: bpy.types.DepsgraphObjectInstance,
        mesh: bpy.types.Mesh,
    ) -> tuple[object, ...]:
        """What an evaluated mesh is known by: the data it comes from, or the object that made it.

        A key is given once in a walk. If it goes to another mesh in a later walk, that mesh lies
        at another address and so is read.
        """
        owner = ob.original.as_pointer()
        key: tuple[object, ...] = ("object", owner)
        is_own = not instance.is_instance or ob.data == mesh
        if is_own and not ob.modifiers and ob.original.data is not None:
            key = ("data", ob.original.data.as_pointer())
        number = 0
        while key in self._taken:
            number += 1
            key = ("object", owner, number)
        self._taken.add(key)
        return key

    def _remember(self, index: np.ndarray) -> None:
        """Note which objects may later be read alone, and where the lights are."""
        self.objects.known = {
            owner: source if self._is_alone(owner, source) else None
            for owner, source in ((o, self.sources[n]) for o, n in self._own.items())
        }
        self.objects.known.update(dict.fromkeys(self._shown_by_others))
        lights = [number for number, source in enumerate(self.sources) if source.light]
        self.objects.lights = [
            (position, self.sources[index[position]].light)
            for position in np.flatnonzero(np.isin(index, lights)).tolist()
        ]

    def _is_alone(self, owner: int, source: Source) -> bool:
        """True if nothing but the object itself tells what its own row shows."""
        return owner not in self._shown_by_others and len(self._users.get(source.mesh, ())) <= 1


def _instancer_flags(ob: bpy.types.Object) -> tuple[bool, ...]:
    return ob.show_instancer_for_render, ob.show_instancer_for_viewport


def _may_show(ob: bpy.types.Object) -> bool:
    """True for an object that may have got geometry."""
    return ob.type in GEOMETRY and (ob.type != "MESH" or _has_faces(ob.data))


def _has_faces(mesh: bpy.types.ID | None) -> bool:
    """True for an evaluated mesh with faces, or one in edit mode that hides what it has."""
    return isinstance(mesh, bpy.types.Mesh) and (len(mesh.polygons) > 0 or mesh.is_editmode)
