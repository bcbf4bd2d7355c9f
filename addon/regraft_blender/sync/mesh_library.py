"""The meshes a scene's instances share, each read only when it may have changed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from . import mesh_reader
from .delta import MeshData, SceneDelta
from .mesh_reader import Shape
from .shape_origin import ShapeOrigin, origin_of

# What a mesh is known by from frame to frame: its kind and original data's or object's address.
MeshKey = tuple[Any, ...]


@dataclass
class Record:
    """One native mesh: where it came from, and what was last read. `origin` tells what its shape
    follows from, unless it is None; `is_reshaped` that this has changed since."""

    handle: int
    key: MeshKey
    address: int = 0
    is_stale: bool = True
    name: str = ""
    shape: Shape | None = None
    origin: ShapeOrigin | None = None
    is_reshaped: bool = True
    checksum: int = 0
    slot_count: int = 1
    bytes: int = 0


@dataclass
class Reads:
    """What one frame's reading of meshes came to."""

    read: int = 0
    unchanged: int = 0
    bytes: int = 0


class MeshLibrary:
    """Records by key. `reads` counts what the current frame read."""

    def __init__(self) -> None:
        self.reads = Reads()
        self._records: dict[MeshKey, Record] = {}
        self._by_handle: dict[int, Record] = {}
        self._by_source: dict[int, set[int]] = {}
        self._next_handle = 0

    def __contains__(self, handle: int) -> bool:
        return handle in self._by_handle

    def __getitem__(self, handle: int) -> Record:
        return self._by_handle[handle]

    def bytes(self) -> int:
        """What reading all of them takes."""
        return sum(record.bytes for record in self._by_handle.values())

    def invalidate(self, sources: set[int] | None) -> None:
        """Mark meshes that have to be read before they are next shown: all of them, or those that
        come from the original objects or data at the addresses `sources`."""
        if sources is None:
            for record in self._by_handle.values():
                record.is_stale = record.is_reshaped = True
            return
        for source in sources & self._by_source.keys():
            for handle in self._by_source[source]:
                record = self._by_handle[handle]
                record.is_stale = True
                record.is_reshaped |= record.origin is None or record.origin.data[0] == source

    def link(self, handle: int, source: int) -> None:
        """Remember that a mesh comes from the original object or data at address `source`."""
        self._by_source.setdefault(source, set()).add(handle)

    def record(self, key: MeshKey, address: int) -> Record:
        """The record of `key`, whose evaluated mesh is at `address` now; a mesh elsewhere than
        last time is another evaluation and has to be read."""
        record = self._records.get(key)
        if record is None:
            record = Record(self._next_handle, key)
            self._next_handle += 1
            self._records[key] = self._by_handle[record.handle] = record
        record.is_stale = record.is_stale or record.address != address
        record.address = address
        return record

    def read(
        self, record: Record, ob: bpy.types.Object, mesh: bpy.types.Mesh, delta: SceneDelta
    ) -> None:
        """Read `mesh` if its record is stale, and note in `delta` what changed."""
        if not record.is_stale:
            return
        # Edit mode keeps its mesh in another form until it is asked for a copy.
        if mesh.is_editmode:
            self._read_now(record, ob, ob.to_mesh(), delta)
            ob.to_mesh_clear()
        else:
            self._read_now(record, ob, mesh, delta)
        record.is_stale = False

    def _read_now(
        self, record: Record, ob: bpy.types.Object, mesh: bpy.types.Mesh, delta: SceneDelta
    ) -> None:
        positions = mesh_reader.read_positions(mesh)
        shape = self._read_shape(record, ob, mesh)
        record.bytes = positions.nbytes + shape.nbytes()
        self.reads.read += 1
        self.reads.bytes += positions.nbytes
        checksum = int(positions.view(np.uint32).sum(dtype=np.uint64))
        is_still, record.checksum = checksum == record.checksum, checksum
        if record.shape is None:
            delta.added_meshes[record.handle] = _take(record, mesh, shape, positions)
            return
        changes = shape.differs_in(record.shape)
        # Sharp edges that follow an angle flicker while a mesh deforms; the fans are kept then.
        if changes and (is_still or changes != ["sharp_edges"]):
            delta.retopologised[record.handle] = _take(record, mesh, shape, positions)
            return
        # The library compares; the checksum, which can collide, only counts.
        delta.deformed[record.handle] = positions
        self.reads.unchanged += is_still

    def _read_shape(self, record: Record, ob: bpy.types.Object, mesh: bpy.types.Mesh) -> Shape:
        """The shape of `mesh`; the one that is known if it cannot be another."""
        origin, old = origin_of(ob, mesh), record.origin
        is_same = origin is not None and origin == old and not record.is_reshaped
        record.origin, record.is_reshaped = origin, False
        if is_same and record.shape is not None:
            return record.shape
        shape = mesh_reader.read_shape(mesh)
        self.reads.bytes += shape.nbytes()
        return shape

    def drop_unused(self, used: set[int], delta: SceneDelta) -> None:
        """Forget the meshes that no instance uses."""
        for handle in self._by_handle.keys() - used:
            record = self._by_handle.pop(handle)
            del self._records[record.key]
            delta.removed_meshes.append(handle)
        for handles in self._by_source.values():
            handles &= used


def _take(
    record: Record, mesh: bpy.types.Mesh, shape: Shape, positions: npt.NDArray[np.float32]
) -> MeshData:
    """Read the rest of a mesh whose shape is new."""
    data = mesh_reader.read_mesh(mesh, shape, positions)
    record.shape, record.name = shape, data.name
    record.slot_count = 1 if data.slots is None else int(data.slots.max(initial=0)) + 1
    return data
