"""What changed in a scene since it was last read, as plain values, and how the library learns it.

No Blender in here: the reader fills a `SceneDelta`, the `SceneMirror` applies it to a
`regraft.Scene`. Meshes, instances, groups and materials are named by small integers that the
reader hands out ("handles"); the mirror keeps the native id of each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

NONE = 0xFFFFFFFF
Handles = npt.NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class MeshData:
    """A triangle mesh in its object's frame, metres.

    `vertices` (V,3) float32, `triangles` (T,3) uint32, `slots` (T,) uint16 or None for all 0,
    `normal_ids` (T,3) uint32 or None for flat; as `regraft.Scene.add_mesh` takes them.
    """

    name: str
    vertices: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.uint32]
    slots: npt.NDArray[np.uint16] | None = None
    normal_ids: npt.NDArray[np.uint32] | None = None


@dataclass(frozen=True)
class GroupData:
    """A level of the scene's hierarchy; `parent` is a group handle or None."""

    handle: int
    parent: int | None
    name: str


@dataclass(frozen=True, eq=False)
class InstanceBatch:
    """N new instances: handles, mesh handles and groups (NONE for none) (N,) uint32,
    `transforms` (N,4,4) float64 object to world, material handles of each, pass indices (N,)."""

    handles: Handles
    meshes: Handles
    transforms: npt.NDArray[np.float64]
    groups: Handles
    materials: Sequence[tuple[int, ...]]
    object_indices: Handles


@dataclass(frozen=True, eq=False)
class MaterialTable:
    """All materials, one row each, linear: (M,4), (M,), (M,) and (M,3) float32."""

    base_color: npt.NDArray[np.float32]
    metallic: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    emission: npt.NDArray[np.float32]


def no_handles() -> Handles:
    """An empty list of handles."""
    return np.empty(0, np.uint32)


def no_transforms() -> npt.NDArray[np.float64]:
    """An empty list of matrices."""
    return np.empty((0, 4, 4), np.float64)


@dataclass
class SceneDelta:
    """Everything that changed, by kind; whatever is empty or None did not change."""

    groups: list[GroupData] = field(default_factory=list)
    added_meshes: dict[int, MeshData] = field(default_factory=dict)
    removed_meshes: list[int] = field(default_factory=list)
    retopologised: dict[int, MeshData] = field(default_factory=dict)
    deformed: dict[int, npt.NDArray[np.float32]] = field(default_factory=dict)
    added: InstanceBatch | None = None
    removed: Handles = field(default_factory=no_handles)
    moved: Handles = field(default_factory=no_handles)
    transforms: npt.NDArray[np.float64] = field(default_factory=no_transforms)
    shown: Handles = field(default_factory=no_handles)
    hidden: Handles = field(default_factory=no_handles)
    rematerialised: dict[int, tuple[int, ...]] = field(default_factory=dict)
    materials: MaterialTable | None = None
    lights: tuple[Any, ...] | None = None
    world: tuple[float, float, float] | None = None
    left_out: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def is_empty(self) -> bool:
        """True if applying it would change nothing."""
        lists = (self.removed, self.moved, self.shown, self.hidden)
        values = (self.added, self.materials, self.lights, self.world)
        return not (
            any(len(ids) for ids in lists)
            or any(value is not None for value in values)
            or self.groups
            or self.changes_meshes()
            or self.rematerialised
        )

    def changes_meshes(self) -> bool:
        """True if some mesh comes, goes or takes another shape."""
        kinds = (self.added_meshes, self.removed_meshes, self.retopologised, self.deformed)
        return any(kinds)


class IdMap:
    """Native id of each handle, as an array so that whole lists translate at once."""

    def __init__(self) -> None:
        self._ids = np.full(16, NONE, np.uint32)

    def __getitem__(self, handles: Any) -> Any:
        return self._ids[handles]

    def set(self, handles: Any, ids: Any) -> None:
        """Remember the native `ids` of `handles`, numbers or arrays of equal length."""
        needed = int(np.max(handles, initial=0)) + 1
        if needed > len(self._ids):
            grown = np.full(max(needed, 2 * len(self._ids)), NONE, np.uint32)
            grown[: len(self._ids)] = self._ids
            self._ids = grown
        self._ids[handles] = ids


class SceneMirror:
    """Applies deltas to one native scene and knows the native id of every handle."""

    def __init__(self, scene: Any) -> None:
        self.scene = scene
        self.meshes = IdMap()
        self.instances = IdMap()
        self.groups = IdMap()

    def apply(self, delta: SceneDelta) -> None:
        """Bring the native scene up to date. Raises what the library raises, naming the thing."""
        self._add_groups(delta)
        if delta.materials is not None:
            table = delta.materials
            self.scene.set_materials(
                table.base_color, table.metallic, table.roughness, table.emission
            )
        self._change_meshes(delta)
        self._change_instances(delta)
        for handle in delta.removed_meshes:
            self.scene.remove_mesh(int(self.meshes[handle]))
        if delta.lights is not None:
            self.scene.set_lights(delta.lights)
        if delta.world is not None:
            self.scene.set_world(delta.world)

    def _add_groups(self, delta: SceneDelta) -> None:
        for group in delta.groups:
            parent = None if group.parent is None else int(self.groups[group.parent])
            self.groups.set(group.handle, self.scene.add_group(parent, name=group.name))

    def _change_meshes(self, delta: SceneDelta) -> None:
        for handle, mesh in delta.added_meshes.items():
            mesh_id = self.scene.add_mesh(
                mesh.vertices,
                mesh.triangles,
                name=mesh.name,
                slots=mesh.slots,
                normal_ids=mesh.normal_ids,
            )
            self.meshes.set(handle, mesh_id)
        for handle, mesh in delta.retopologised.items():
            self.scene.set_mesh(
                int(self.meshes[handle]),
                mesh.vertices,
                mesh.triangles,
                slots=mesh.slots,
                normal_ids=mesh.normal_ids,
            )
        for handle, vertices in delta.deformed.items():
            self.scene.set_vertices(int(self.meshes[handle]), vertices)

    def _change_instances(self, delta: SceneDelta) -> None:
        if len(delta.removed):
            self.scene.remove_instances(self.instances[delta.removed])
        if delta.added is not None:
            self._add_instances(delta.added)
        if len(delta.moved):
            self.scene.set_transforms(self.instances[delta.moved], delta.transforms)
        for handles, flag in ((delta.shown, True), (delta.hidden, False)):
            for instance_id in self.instances[handles].tolist():
                self.scene.set_visible(instance_id, flag)
        for handle, materials in delta.rematerialised.items():
            self.scene.set_instance_materials(int(self.instances[handle]), materials)

    def _add_instances(self, batch: InstanceBatch) -> None:
        groups = batch.groups.copy()
        grouped = groups != NONE
        groups[grouped] = self.groups[groups[grouped]]
        ids = self.scene.add_instances(
            self.meshes[batch.meshes],
            batch.transforms,
            groups=groups,
            materials=list(batch.materials),
            object_indices=batch.object_indices,
        )
        self.instances.set(batch.handles, ids)
