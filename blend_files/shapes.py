"""Polygon shapes to build props from: boxes, lathes, prisms, grids, joined and moved.

A shape is plain data in metres; only `mesh` and `bevelled` touch Blender.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import bmesh
import bpy
import numpy as np
from mathutils import Euler
from numpy.typing import NDArray
from scene_kit import mesh_from_arrays

Array = NDArray[np.float64]
Triple = Sequence[float]


@dataclass
class Shape:
    """Vertices (V, 3), faces as lists of vertices wound outwards, and the material slot of each
    face.
    """

    vertices: Array
    faces: list[list[int]]
    slots: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.slots = self.slots or [0] * len(self.faces)

    def __add__(self, other: "Shape") -> "Shape":
        shifted = [[v + len(self.vertices) for v in face] for face in other.faces]
        return Shape(
            np.vstack([self.vertices, other.vertices]),
            self.faces + shifted,
            self.slots + other.slots,
        )

    @property
    def triangle_count(self) -> int:
        return sum(len(face) - 2 for face in self.faces)

    def moved(self, x: float = 0, y: float = 0, z: float = 0) -> "Shape":
        return replace(self, vertices=self.vertices + np.array([x, y, z]))

    def scaled(self, x: float, y: float, z: float) -> "Shape":
        return replace(self, vertices=self.vertices * np.array([x, y, z]))

    def turned(self, x: float = 0, y: float = 0, z: float = 0) -> "Shape":
        """Turned by Euler angles in radians, x first."""
        matrix = np.array(Euler((x, y, z)).to_matrix())
        return replace(self, vertices=self.vertices @ matrix.T)

    def painted(self, slot: int) -> "Shape":
        return replace(self, slots=[slot] * len(self.faces))


def joined(parts: Sequence[Shape]) -> Shape:
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def box(x: float, y: float, z: float) -> Shape:
    """A box of these lengths, centred on the origin."""
    corners = [(i, j, k) for k in (-0.5, 0.5) for j in (-0.5, 0.5) for i in (-0.5, 0.5)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return Shape(np.array(corners) * (x, y, z), faces)


def lathe(profile: Sequence[tuple[float, float]], segments: int) -> Shape:
    """Turns (radius, height) points, listed upwards, round Z; an end of radius above zero gets a
    flat lid.
    """
    angles = np.arange(segments) * 2 * math.pi / segments
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(segments)], axis=1)
    tips = [(radius, height) for radius, height in profile if radius == 0]
    body = [(radius, height) for radius, height in profile if radius > 0]
    vertices = np.concatenate([ring * radius + (0, 0, height) for radius, height in body])
    around = [(s, (s + 1) % segments) for s in range(segments)]
    faces = [
        [low + a, low + b, low + segments + b, low + segments + a]
        for low in range(0, (len(body) - 1) * segments, segments)
        for a, b in around
    ]
    top = len(vertices) - segments
    closed_below, closed_above = profile[0][0] == 0, profile[-1][0] == 0
    below, above = len(vertices), len(vertices) + closed_below
    faces += [[below, b, a] for a, b in around] if closed_below else [list(range(segments))[::-1]]
    faces += (
        [[above, top + a, top + b] for a, b in around]
        if closed_above
        else [[top + s for s in range(segments)]]
    )
    ends = np.array([(0, 0, height) for _, height in tips]).reshape(-1, 3)
    return Shape(np.vstack([vertices, ends]), faces)


def cylinder(radius: float, height: float, segments: int = 24) -> Shape:
    """Standing on the origin."""
    return lathe([(radius, 0), (radius, height)], segments)


def prism(outline: Sequence[tuple[float, float]], depth: float) -> Shape:
    """An outline (x, z), anticlockwise seen from −Y, pushed from y = 0 to y = depth."""
    count = len(outline)
    front = np.array([(x, 0.0, z) for x, z in outline])
    sides = [[s, s + count, (s + 1) % count + count, (s + 1) % count] for s in range(count)]
    faces = [list(range(count)), [count + s for s in range(count)][::-1], *sides]
    return Shape(np.vstack([front, front + np.array([0, depth, 0])]), faces)


def icosphere(radius: float, subdivisions: int) -> Shape:
    """A geodesic sphere of 20·4^(subdivisions − 1) triangles."""
    ball = bmesh.new()
    bmesh.ops.create_icosphere(ball, subdivisions=subdivisions, radius=radius)
    return _taken(ball)


def bevelled(shape: Shape, width: float, segments: int = 1) -> Shape:
    """All edges rounded off; one material slot only."""
    work = bmesh.new()
    corners = [work.verts.new(vertex) for vertex in shape.vertices]
    for face in shape.faces:
        work.faces.new([corners[v] for v in face])
    sharp = [edge for edge in work.edges if edge.calc_face_angle(0) > 0.5]
    bmesh.ops.bevel(
        work,
        geom=sharp,
        offset=width,
        segments=segments,
        affect="EDGES",
        profile=0.5,
        clamp_overlap=True,
    )
    return _taken(work)


def _taken(work: bmesh.types.BMesh) -> Shape:
    work.verts.index_update()
    vertices = np.array([vertex.co[:] for vertex in work.verts])
    faces = [[vertex.index for vertex in face.verts] for face in work.faces]
    work.free()
    return Shape(vertices, faces)


def grid(columns: int, rows: int) -> tuple[Array, NDArray[np.int64]]:
    """A unit square of columns × rows quads: vertices (V, 3) at z = 0 row by row, faces
    (columns·rows, 4).
    """
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    return vertices, np.stack([first, first + 1, first + columns + 2, first + columns + 1], axis=1)


def mesh(
    name: str, shape: Shape, materials: Sequence[bpy.types.Material], *, smooth_below: float = 0.0
) -> bpy.types.Mesh:
    """A Blender mesh of a shape; edges flatter than `smooth_below` radians are shaded smooth.

    Sharper ones are split, since newer versions turn the old auto-smooth flag into a modifier, and
    objects with modifiers do not share their mesh.
    """
    corners = np.concatenate([np.array(face) for face in shape.faces])
    sizes = np.array([len(face) for face in shape.faces])
    made = mesh_from_arrays(name, shape.vertices, corners, materials, sizes=sizes)
    made.polygons.foreach_set("material_index", np.array(shape.slots, np.int32))
    if smooth_below:
        _shade_smooth(made, smooth_below)
    return made


def _shade_smooth(made: bpy.types.Mesh, angle: float) -> None:
    made.polygons.foreach_set("use_smooth", np.ones(len(made.polygons), bool))
    work = bmesh.new()
    work.from_mesh(made)
    sharp = [edge for edge in work.edges if edge.is_manifold and edge.calc_face_angle() > angle]
    bmesh.ops.split_edges(work, edges=sharp)
    work.to_mesh(made)
    work.free()
