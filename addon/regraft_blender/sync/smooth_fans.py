"""Which corners of a mesh share a shading normal, from its smooth faces and edges.

Round each vertex, the corners reached from one another across smooth edges form a fan and share
one normal. Corners, faces and edges are Blender's; everything here is NumPy on index arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FLAT = 0xFFFFFFFF
Ints = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Corners:
    """The corners of F faces, face after face: `vertex` and `edge` (the one from this corner to
    the next) (C,) int32, `face_starts` (F,) int32."""

    vertex: Ints
    edge: Ints
    face_starts: Ints

    def face_sizes(self) -> npt.NDArray[np.int64]:
        """(F,) corners of each face."""
        return np.diff(self.face_starts, append=len(self.vertex))

    def faces(self) -> npt.NDArray[np.int64]:
        """(C,) the face of each corner."""
        return np.repeat(np.arange(len(self.face_starts)), self.face_sizes())

    def following(self) -> npt.NDArray[np.int64]:
        """(C,) the next corner of the same face."""
        following = np.arange(1, len(self.vertex) + 1)
        ends = self.face_starts + self.face_sizes() - 1
        following[ends] = self.face_starts
        return following


def fan_ids(corners: Corners, smooth_faces: Bools, smooth_edges: Bools) -> npt.NDArray[np.uint32]:
    """(C,) number of each corner's fan, counted from 0; FLAT for the corners of flat faces.

    `smooth_faces` (F,) and `smooth_edges` (E,) say where shading passes. An edge joins two fans
    only if exactly two smooth faces meet there with opposite winding, as in Blender.
    """
    smooth_corners = smooth_faces[corners.faces()]
    first, last = _edge_ends(corners, smooth_corners, smooth_edges)
    labels = _connected(_links(corners, first, last))
    is_lowest = labels == np.arange(len(labels))
    numbers = np.cumsum(is_lowest & smooth_corners, dtype=np.int64) - 1
    return np.where(smooth_corners, numbers[labels], FLAT).astype(np.uint32)


def sharper_than(
    corners: Corners, face_normals: npt.NDArray[np.float32], edge_count: int, angle: float
) -> Bools:
    """(E,) True where two faces meet at more than `angle` radians; normals (F,3), unit."""
    faces = corners.faces()
    first, last = _both_corners(corners.edge, edge_count)
    is_shared = np.bincount(corners.edge, minlength=edge_count) == 2
    cosines = np.einsum("ij,ij->i", face_normals[faces[first]], face_normals[faces[last]])
    return is_shared & (cosines < np.cos(angle))


def _both_corners(edge: Ints, edge_count: int) -> tuple[npt.NDArray[np.int64], ...]:
    """(E,) lowest and highest corner on each edge; 0 where there is none."""
    corners = np.arange(len(edge))
    first, last = np.zeros(edge_count, np.int64), np.zeros(edge_count, np.int64)
    last[edge] = corners
    first[edge[::-1]] = corners[::-1]
    return first, last


def _edge_ends(
    corners: Corners, smooth_corners: Bools, smooth_edges: Bools
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """The two corners on each edge that joins fans."""
    first, last = _both_corners(corners.edge, len(smooth_edges))
    joins = smooth_edges & (np.bincount(corners.edge, minlength=len(smooth_edges)) == 2)
    joins &= smooth_corners[first] & smooth_corners[last]
    joins &= corners.vertex[first] != corners.vertex[last]
    return first[joins], last[joins]


def _links(
    corners: Corners, first: npt.NDArray[np.int64], last: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """(2,C) the neighbour of each corner in its fan across its own edge and across the previous
    one; itself where the fan ends.

    An edge runs from corner a to `following(a)` in one face and from b to `following(b)` in the
    other, the other way round: a and following(b) stand on one vertex, b and following(a) on the
    other.
    """
    following = corners.following()
    links = np.tile(np.arange(len(corners.vertex)), (2, 1))
    links[0, first], links[0, last] = following[last], following[first]
    links[1, following[last]], links[1, following[first]] = first, last
    return links


def _connected(links: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """(C,) the lowest corner of each corner's fan: lowest labels spread along the links, and
    labels jump to their own labels, so that a fan of n corners needs about log n rounds."""
    labels = np.arange(links.shape[1])
    while True:
        lower = np.minimum(labels, np.minimum(labels[links[0]], labels[links[1]]))
        lower = lower[lower]
        if np.array_equal(lower, labels):
            return labels
        labels = lower
