"""Breaks a convex boulder into shards: the Voronoi cells of points inside it, cut by its faces.

Every cell is found by duality: the planes around a point, as points n/d, span a convex hull whose
faces are the cell's corners (Preparata and Shamos, Computational Geometry, 1985, section 7.3).
Blender's own hull does the work.
"""

from dataclasses import dataclass, replace

import bmesh
import numpy as np
from mathutils import kdtree
from numpy.typing import NDArray
from scene_kit import fibonacci_sphere

Array = NDArray[np.float64]
_NEIGHBOURS = (
    44  # bisectors tried for a cell; a Voronoi cell has about 16 faces, none here above 34
)


@dataclass
class Planes:
    """The faces of a convex solid round the origin: unit normals (P, 3), distances (P,)."""

    normals: Array
    distances: Array

    def depth(self, points: Array) -> Array:
        """(N,) distance of points (N, 3) to the nearest face, positive inside."""
        return np.asarray(np.min(self.distances - points @ self.normals.T, axis=1))


@dataclass
class Shards:
    """Polygons of all shards: vertices (V, 3), flat corners, sizes (F,), whether a face was the
    solid's surface (F,), shard of each vertex (V,), the points (S, 3) the shards grew from, and
    the solid's centre (3,).
    """

    vertices: Array
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    is_surface: NDArray[np.bool_]
    shard: NDArray[np.int64]
    points: Array
    centre: Array

    def moved(self, offset: Array) -> "Shards":
        """The same shards elsewhere."""
        moved = replace(self, vertices=self.vertices + offset, points=self.points + offset)
        return replace(moved, centre=self.centre + offset)


def boulder(radii: tuple[float, float, float], faces: int, rng: np.random.Generator) -> Planes:
    """A rough-hewn ellipsoid of so many flat faces."""
    normals = fibonacci_sphere(faces) + rng.normal(0, 0.12, (faces, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    support = np.linalg.norm(normals * np.array(radii), axis=1)
    return Planes(normals, support * rng.uniform(0.9, 1.0, faces))


def scatter(solid: Planes, count: int, rng: np.random.Generator) -> tuple[Array, float]:
    """Points (count, 3) inside a solid, no two closer than the spacing also returned (dart
    throwing).
    """
    reach = float(solid.distances.max()) * 1.15
    trial = rng.uniform(-reach, reach, (200_000, 3))
    volume = (2 * reach) ** 3 * float(np.mean(solid.depth(trial) > 0))
    spacing = 0.74 * (volume / count) ** (1 / 3)
    kept = _throw_darts(solid, count, spacing, reach, rng)
    order = np.lexsort(np.floor(kept / (4 * spacing)).T)  # neighbours close in the file pack better
    return kept[order], spacing


def _throw_darts(
    solid: Planes, count: int, spacing: float, reach: float, rng: np.random.Generator
) -> Array:
    grid: dict[tuple[int, ...], Array] = {}
    steps = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    kept: list[Array] = []
    while len(kept) < count:
        dart = rng.uniform(-reach, reach, (1, 3))
        if solid.depth(dart)[0] < 0.25 * spacing:
            continue
        x, y, z = np.floor(dart[0] / spacing).astype(int)
        near = (grid.get((x + i, y + j, z + k)) for i, j, k in steps)
        if all(other is None or np.linalg.norm(other - dart[0]) > spacing for other in near):
            grid[x, y, z] = dart[0]
            kept.append(dart[0])
    return np.array(kept)


def shatter(solid: Planes, count: int, rng: np.random.Generator, step: float) -> Shards:
    """Breaks a solid into `count` shards; vertices are rounded to multiples of `step` metres."""
    points, spacing = scatter(solid, count, rng)
    tree = kdtree.KDTree(len(points))
    for index, point in enumerate(points):
        tree.insert(point, index)
    tree.balance()
    cells = [_cell(point, points, tree, solid, spacing) for point in points]
    vertices = np.concatenate([cell[0] for cell in cells])
    counts = np.array([len(cell[0]) for cell in cells])
    first = np.cumsum(counts) - counts
    faces = [
        [start + v for v in face]
        for start, cell in zip(first, cells, strict=True)
        for face in cell[1]
    ]
    return Shards(
        np.round(vertices / step) * step,
        np.concatenate([np.array(face) for face in faces]),
        np.array([len(face) for face in faces]),
        np.concatenate([cell[2] for cell in cells]),
        np.repeat(np.arange(len(points)), counts),
        points,
        np.zeros(3),
    )


def _cell(
    point: Array, points: Array, tree: kdtree.KDTree, solid: Planes, spacing: float
) -> tuple[Array, list[list[int]], NDArray[np.bool_]]:
    """One shard: vertices in the solid's frame, faces, and which of them lie on the solid's
    surface.
    """
    others = points[[index for _, index, _ in tree.find_n(point, _NEIGHBOURS)][1:]]
    away = others - point
    distance = np.linalg.norm(away, axis=1)
    to_faces = solid.distances - solid.normals @ point
    close = to_faces < 4 * spacing
    duals = np.vstack(
        [away / (distance**2 / 2)[:, None], solid.normals[close] / to_faces[close, None]]
    )
    vertices, faces = _hull(_corners(duals), spacing * 0.02)
    centres = np.array([vertices[face].mean(axis=0) for face in faces]) + point
    return vertices + point, faces, solid.depth(centres) < 0.02 * spacing


def _corners(duals: Array) -> Array:
    """The corners of the cell whose planes are n·x = 1 for every dual point n."""
    mesh = bmesh.new()
    bmesh.ops.convex_hull(mesh, input=[mesh.verts.new(dual) for dual in duals])
    triangles = np.array([[corner.co[:] for corner in face.verts] for face in mesh.faces])
    mesh.free()
    return np.linalg.solve(triangles, np.ones((len(triangles), 3, 1)))[:, :, 0]


def _hull(corners: Array, merge: float) -> tuple[Array, list[list[int]]]:
    """The convex hull of points as vertices and polygons; points closer than `merge` become one."""
    mesh = bmesh.new()
    for corner in corners:
        mesh.verts.new(corner)
    bmesh.ops.remove_doubles(mesh, verts=mesh.verts, dist=merge)
    bmesh.ops.convex_hull(mesh, input=mesh.verts)
    bmesh.ops.delete(mesh, geom=[v for v in mesh.verts if not v.link_faces], context="VERTS")
    bmesh.ops.dissolve_limit(mesh, angle_limit=0.02, verts=mesh.verts, edges=mesh.edges)
    mesh.verts.index_update()
    vertices = np.array([vertex.co[:] for vertex in mesh.verts])
    faces = [[vertex.index for vertex in face.verts] for face in mesh.faces]
    if len(mesh.verts) - len(mesh.edges) + len(mesh.faces) != 2:
        raise ValueError("a shard is not a closed convex solid")
    mesh.free()
    return vertices, faces
