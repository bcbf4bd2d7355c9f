"""Shading normals' fans, against a search over corners one by one."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from regraft_blender.sync.smooth_fans import FLAT, Corners, fan_ids, sharper_than

# A strip of faces round vertex 4, corner by corner: four quads of a 3 × 3 grid.
GRID = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]


def corners_of(faces: list[list[int]]) -> tuple[Corners, dict[tuple[int, int], int]]:
    """Corners of faces given by vertices, and the number of each edge."""
    edges: dict[tuple[int, int], int] = {}
    corner_edges = []
    for face in faces:
        for here, there in zip(face, face[1:] + face[:1], strict=True):
            ends = min(here, there), max(here, there)
            corner_edges.append(edges.setdefault(ends, len(edges)))
    sizes = [len(face) for face in faces]
    starts = np.cumsum([0, *sizes[:-1]]).astype(np.int32)
    vertices = np.array([v for face in faces for v in face], np.int32)
    return Corners(vertices, np.array(corner_edges, np.int32), starts), edges


def partition(ids: np.ndarray) -> set[frozenset[int]]:
    """Corners grouped by id, flat ones left out."""
    groups = defaultdict(set)
    for corner, number in enumerate(ids.tolist()):
        if number != FLAT:
            groups[number].add(corner)
    return {frozenset(group) for group in groups.values()}


def searched(corners: Corners, smooth_faces: np.ndarray, smooth_edges: np.ndarray) -> set:
    """The same by walking from corner to corner."""
    faces, following = corners.faces(), corners.following()
    by_edge = defaultdict(list)
    for corner, edge in enumerate(corners.edge.tolist()):
        by_edge[edge].append(corner)
    neighbours = defaultdict(set)
    for edge, ends in by_edge.items():
        if len(ends) != 2 or not smooth_edges[edge] or not smooth_faces[faces[ends]].all():
            continue
        a, b = ends
        if corners.vertex[a] != corners.vertex[b]:
            for one, other in ((a, following[b]), (b, following[a])):
                neighbours[int(one)].add(int(other))
                neighbours[int(other)].add(int(one))
    seen: set[int] = set()
    fans = set()
    for corner in np.flatnonzero(smooth_faces[faces]).tolist():
        if corner in seen:
            continue
        fan, pending = set(), [corner]
        while pending:
            here = pending.pop()
            if here not in fan:
                fan.add(here)
                pending += neighbours[here]
        seen |= fan
        fans.add(frozenset(fan))
    return fans


def test_all_smooth_gives_one_fan_a_vertex() -> None:
    corners, edges = corners_of(GRID)
    ids = fan_ids(corners, np.ones(4, bool), np.ones(len(edges), bool))
    assert len(set(ids.tolist())) == 9
    for number in set(ids.tolist()):
        assert len(set(corners.vertex[ids == number].tolist())) == 1


def test_a_sharp_edge_splits_only_where_it_ends_a_fan() -> None:
    corners, edges = corners_of(GRID)
    smooth = np.ones(len(edges), bool)
    smooth[edges[1, 4]] = False
    ids = fan_ids(corners, np.ones(4, bool), smooth)
    at_border = {int(i) for i in ids[corners.vertex == 1]}
    in_middle = {int(i) for i in ids[corners.vertex == 4]}
    assert len(at_border) == 2
    # One sharp edge does not part the corners round an inner vertex: they meet the other way.
    assert len(in_middle) == 1


def test_a_flat_face_is_flat_and_parts_its_neighbours() -> None:
    corners, edges = corners_of([[0, 1, 2], [2, 1, 3], [2, 3, 4]])
    ids = fan_ids(corners, np.array([True, False, True]), np.ones(len(edges), bool))
    assert (ids[3:6] == FLAT).all()
    assert ids[2] != ids[6]


def test_faces_wound_against_each_other_are_not_joined() -> None:
    corners, edges = corners_of([[0, 1, 2], [1, 2, 3]])
    ids = fan_ids(corners, np.ones(2, bool), np.ones(len(edges), bool))
    assert len(set(ids.tolist())) == 6


@given(st.data())
def test_fans_equal_those_found_by_search(data: st.DataObject) -> None:
    count = data.draw(st.integers(1, 24))
    faces = [
        data.draw(st.lists(st.integers(0, 9), min_size=3, max_size=5, unique=True))
        for _ in range(count)
    ]
    corners, edges = corners_of(faces)
    flags = st.lists(st.booleans(), min_size=count, max_size=count)
    smooth_faces = np.array(data.draw(flags))
    smooth_edges = np.array(
        data.draw(st.lists(st.booleans(), min_size=len(edges), max_size=len(edges)))
    )
    ids = fan_ids(corners, smooth_faces, smooth_edges)
    assert partition(ids) == searched(corners, smooth_faces, smooth_edges)
    known = ids[ids != FLAT]
    assert len(known) == 0 or set(known.tolist()) == set(range(int(known.max()) + 1))


@pytest.mark.parametrize(("angle", "is_sharp"), [(1.0, True), (2.0, False)])
def test_edges_are_sharp_above_the_angle_between_their_faces(angle: float, is_sharp: bool) -> None:
    corners, edges = corners_of([[0, 1, 2], [2, 1, 3]])
    normals = np.array([[0, 0, 1], [1, 0, 0]], np.float32)
    sharp = sharper_than(corners, normals, len(edges), angle)
    assert sharp[edges[1, 2]] == is_sharp
    assert sharp.sum() == is_sharp
