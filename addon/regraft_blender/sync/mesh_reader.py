"""Reads an evaluated Blender mesh into arrays, by the fastest way each version has.

A mesh is read in two steps: its positions, which change with every deformation, and its shape
(corners, faces, slots, smoothness), which rarely changes and is mostly just compared.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from . import raw_memory, smooth_fans
from .delta import MeshData
from .smooth_fans import Corners

Ints = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]
MAX_SLOTS = 0xFFFF


@dataclass(frozen=True, eq=False)
class Shape:
    """Everything of a mesh that its triangles, slots and shading normals follow from.

    `corner_verts` (C,) int32, `face_starts` (F,) int32 or None if all are triangles, `slots` (F,)
    int32 or None if all 0, `flat_faces` (F,) bool or None if all are smooth, `sharp_edges` (E,)
    bool or None if there are none, `smooth_angle` radians or None if no angle breaks shading.
    """

    vertex_count: int
    corner_verts: Ints
    face_starts: Ints | None
    slots: Ints | None
    flat_faces: Bools | None
    sharp_edges: Bools | None
    smooth_angle: float | None

    def differs_in(self, other: Shape) -> list[str]:
        """Names of the fields that are not equal."""
        return [
            field.name
            for field in fields(self)
            if not _equal(getattr(self, field.name), getattr(other, field.name))
        ]

    def nbytes(self) -> int:
        """Memory its arrays take."""
        values = (getattr(self, field.name) for field in fields(self))
        return sum(value.nbytes for value in values if isinstance(value, np.ndarray))

    def starts(self) -> Ints:
        """(F,) first corner of each face."""
        if self.face_starts is not None:
            return self.face_starts
        return np.arange(0, len(self.corner_verts), 3, dtype=np.int32)


def _equal(one: Any, other: Any) -> bool:
    return one is other or np.array_equal(one, other)


def read_positions(mesh: bpy.types.Mesh) -> npt.NDArray[np.float32]:
    """(V,3) float32 vertex positions, object space, metres."""
    positions = np.empty(len(mesh.vertices) * 3, np.float32)
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        attribute.data.foreach_get("vector", positions)
    else:
        mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def read_shape(mesh: bpy.types.Mesh) -> Shape:
    """The mesh's shape, as copies."""
    is_triangles = len(mesh.loops) == 3 * len(mesh.polygons)
    return Shape(
        vertex_count=len(mesh.vertices),
        corner_verts=_corners(mesh, "vertex"),
        face_starts=None if is_triangles else _face_starts(mesh),
        slots=_slots(mesh),
        flat_faces=_flat_faces(mesh),
        sharp_edges=_sharp_edges(mesh),
        smooth_angle=mesh.auto_smooth_angle if getattr(mesh, "use_auto_smooth", False) else None,
    )


def read_mesh(mesh: bpy.types.Mesh, shape: Shape, positions: npt.NDArray[np.float32]) -> MeshData:
    """The triangles of `mesh`, whose shape and positions were just read."""
    corners, faces = _triangle_corners(mesh, shape)
    triangles = np.ascontiguousarray(shape.corner_verts[corners].astype(np.uint32, copy=False))
    slots = None
    if shape.slots is not None:
        slots = np.clip(shape.slots[faces], 0, MAX_SLOTS).astype(np.uint16)
    normal_ids = _normal_ids(mesh, shape, triangles, corners)
    return MeshData(mesh.name, positions, triangles, slots, normal_ids)


def _corners(mesh: bpy.types.Mesh, what: str) -> Ints:
    """(C,) the `vertex` or `edge` of each corner."""
    values = np.empty(len(mesh.loops), np.int32)
    attribute = mesh.attributes.get(".corner_vert" if what == "vertex" else ".corner_edge")
    if attribute is not None:
        attribute.data.foreach_get("value", values)
        return values
    try:
        rows = raw_memory.view(
            mesh.loops,
            raw_memory.LOOP,
            lambda loop, row: (loop.vertex_index, loop.edge_index) == tuple(row),
        )
    except raw_memory.LayoutError:
        mesh.loops.foreach_get(f"{what}_index", values)
        return values
    return rows[what].copy()


def _face_starts(mesh: bpy.types.Mesh) -> Ints:
    """(F,) the first corner of each face."""
    polygons = mesh.polygons
    layout = raw_memory.FACE_START if _is_attribute_based(mesh) else raw_memory.POLYGON
    try:
        rows = raw_memory.view(polygons, layout, lambda face, row: face.loop_start == row["start"])
    except raw_memory.LayoutError:
        starts = np.empty(len(polygons), np.int32)
        polygons.foreach_get("loop_start", starts)
        return starts
    return rows["start"].copy()


def _slots(mesh: bpy.types.Mesh) -> Ints | None:
    """(F,) material slot of each face, or None if all are in the first."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None and (_is_attribute_based(mesh) or len(mesh.materials) < 2):
        return None
    slots = np.empty(len(mesh.polygons), np.int32)
    if attribute is not None and attribute.domain == "FACE":
        attribute.data.foreach_get("value", slots)
    else:
        mesh.polygons.foreach_get("material_index", slots)
    return slots if np.count_nonzero(slots) else None


def _flat_faces(mesh: bpy.types.Mesh) -> Bools | None:
    """(F,) True for flat faces, or None if there are none."""
    flat = np.zeros(len(mesh.polygons), np.bool_)
    attribute = mesh.attributes.get("sharp_face")
    if attribute is not None and attribute.domain == "FACE":
        attribute.data.foreach_get("value", flat)
    elif not _is_attribute_based(mesh):
        flat = ~_smooth_flags(mesh)
    return flat if np.count_nonzero(flat) else None


def _smooth_flags(mesh: bpy.types.Mesh) -> Bools:
    """(F,) True for smooth faces, where no attribute tells."""
    mask = raw_memory.SMOOTH_POLYGON
    try:
        rows = raw_memory.view(
            mesh.polygons,
            raw_memory.POLYGON,
            lambda face, row: face.use_smooth == bool(row["flag"] & mask),
        )
    except raw_memory.LayoutError:
        smooth = np.empty(len(mesh.polygons), np.bool_)
        mesh.polygons.foreach_get("use_smooth", smooth)
        return smooth
    return (rows["flag"] & mask).astype(np.bool_)


def _triangle_corners(mesh: bpy.types.Mesh, shape: Shape) -> tuple[Ints, Ints]:
    """(T,3) corners and (T,) face of each triangle, in Blender's order."""
    if shape.face_starts is None:
        count = len(shape.corner_verts) // 3
        faces = np.arange(count, dtype=np.int32)
        return np.arange(3 * count, dtype=np.int32).reshape(-1, 3), faces
    mesh.calc_loop_triangles()
    corners = _loop_triangles(mesh)
    starts = shape.starts()
    # Corner numbers rise from face to face, and a triangle lies in one face.
    faces = np.searchsorted(starts, corners[:, 0], side="right").astype(np.int32) - 1
    return corners, faces


def _loop_triangles(mesh: bpy.types.Mesh) -> Ints:
    """(T,3) corners of each triangle."""
    is_new = _is_attribute_based(mesh)
    layout = raw_memory.CORNER_TRIANGLE if is_new else raw_memory.LOOP_TRIANGLE
    try:
        rows = raw_memory.view(
            mesh.loop_triangles,
            layout,
            lambda triangle, row: list(triangle.loops) == row["corners"].tolist(),
        )
    except raw_memory.LayoutError:
        corners = np.empty(len(mesh.loop_triangles) * 3, np.int32)
        mesh.loop_triangles.foreach_get("loops", corners)
        return corners.reshape(-1, 3)
    return rows["corners"].copy()


def _normal_ids(
    mesh: bpy.types.Mesh, shape: Shape, triangles: npt.NDArray[np.uint32], corners: Ints
) -> npt.NDArray[np.uint32] | None:
    """(T,3) which corners share a shading normal; None for a flat mesh."""
    flat, sharp = shape.flat_faces, shape.sharp_edges
    if flat is not None and flat.all():
        return None
    if flat is None and sharp is None and shape.smooth_angle is None:
        return triangles
    faces = Corners(shape.corner_verts, _corners(mesh, "edge"), shape.starts())
    smooth_edges = np.ones(len(mesh.edges), np.bool_) if sharp is None else ~sharp
    if shape.smooth_angle is not None:
        smooth_edges &= ~_over_angle(mesh, faces, shape.smooth_angle)
    smooth_faces = np.ones(len(mesh.polygons), np.bool_) if flat is None else ~flat
    return smooth_fans.fan_ids(faces, smooth_faces, smooth_edges)[corners]


def _sharp_edges(mesh: bpy.types.Mesh) -> Bools | None:
    """(E,) True for the edges marked sharp, or None if there are none.

    Up to 4.0 they count only where the mesh has auto smooth on; later versions have the mark
    alone, which a modifier sets from an angle.
    """
    if getattr(mesh, "use_auto_smooth", True) is False:
        return None
    attribute = mesh.attributes.get("sharp_edge")
    sharp = np.zeros(len(mesh.edges), np.bool_)
    if attribute is not None and attribute.domain == "EDGE":
        attribute.data.foreach_get("value", sharp)
    elif not _is_attribute_based(mesh):
        sharp = _sharp_flags(mesh)
    return sharp if np.count_nonzero(sharp) else None


def _sharp_flags(mesh: bpy.types.Mesh) -> Bools:
    """(E,) True for edges marked sharp, where no attribute tells."""
    mask = raw_memory.SHARP_EDGE
    try:
        rows = raw_memory.view(
            mesh.edges,
            raw_memory.EDGE,
            lambda edge, row: edge.use_edge_sharp == bool(row["flag"] & mask),
        )
    except raw_memory.LayoutError:
        sharp = np.empty(len(mesh.edges), np.bool_)
        mesh.edges.foreach_get("use_edge_sharp", sharp)
        return sharp
    return (rows["flag"] & mask).astype(np.bool_)


def _over_angle(mesh: bpy.types.Mesh, corners: Corners, angle: float) -> Bools:
    """(E,) True where the faces meet at more than `angle` radians."""
    normals = np.empty(len(mesh.polygons) * 3, np.float32)
    mesh.polygons.foreach_get("normal", normals)
    return smooth_fans.sharper_than(corners, normals.reshape(-1, 3), len(mesh.edges), angle)


def _is_attribute_based(mesh: bpy.types.Mesh) -> bool:
    """True from 3.6 on, where topology lives in attributes."""
    return mesh.attributes.get(".corner_vert") is not None
