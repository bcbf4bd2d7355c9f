"""closest_point through the NumPy API."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import regraft
from api_shapes import MISS, affine, moved, soup, square

VERTICES, TRIANGLES = square()


@pytest.fixture(scope="module")
def scene() -> regraft.Scene:
    """The square at z = 0 (instance 0) and at z = -1, mirrored (instance 1)."""
    scene = regraft.Scene(threads=2)
    mesh = scene.add_mesh(VERTICES, TRIANGLES)
    scene.add_instance(mesh)
    scene.add_instance(mesh, moved(z=-1) @ np.diag([-1.0, 1, 1, 1]))
    scene.update()
    return scene


def test_a_point_over_a_square_has_its_foot_there(scene: regraft.Scene) -> None:
    found = scene.closest_point(np.array([[0.25, 0.5, 2.0], [0.25, 0.5, -3.0], [3.0, 0.0, 0.0]]))
    assert len(found) == 3
    assert found.distance.tolist() == [2.0, 2.0, 2.0]
    assert found.point.tolist() == [[0.25, 0.5, 0], [0.25, 0.5, -1], [1, 0, 0]]
    assert found.instance_id.tolist() == [0, 1, 0]
    assert np.allclose(found.normal, [[0, 0, 1], [0, 0, -1], [0, 0, 1]])


def test_nothing_is_found_beyond_the_reach(scene: regraft.Scene) -> None:
    found = scene.closest_point(np.array([[0, 0, 2.0], [0, 0, 0.5], [np.nan, 0, 0]]), 1.0)
    assert np.array_equal(found.distance, [np.inf, 0.5, np.inf])
    assert found.instance_id.tolist() == [MISS, 0, MISS]
    assert found.prim_id[0] == MISS
    assert not found.normal[0].any()


def test_arrays_have_the_promised_types(scene: regraft.Scene) -> None:
    found = scene.closest_point(np.zeros((5, 3), np.float32))
    types = {"distance": "f8", "instance_id": "u4", "prim_id": "u4", "u": "f4", "v": "f4"}
    for name, dtype in types.items():
        array = getattr(found, name)
        assert (array.dtype, array.shape) == (np.dtype(dtype), (5,)), name
    assert (found.point.dtype, found.point.shape) == (np.dtype("f8"), (5, 3))
    assert (found.normal.dtype, found.normal.shape) == (np.dtype("f4"), (5, 3))
    assert len(scene.closest_point(np.empty((0, 3)))) == 0


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("layout", ["two-level", "flat"])
def test_weights_name_the_nearest_point(threads: int, layout: str) -> None:
    rng = np.random.default_rng(5)
    scene, corners = regraft.Scene(threads=threads), []
    vertices, triangles = soup(rng, 60)
    mesh = scene.add_mesh(vertices, triangles)
    for _ in range(3):
        matrix = affine(rng)
        scene.add_instance(mesh, matrix)
        corners.append(vertices[triangles].astype(float) @ matrix[:3, :3].T + matrix[:3, 3])
    scene.update(layout=layout)
    points = rng.uniform(-3, 3, (2000, 3))
    found = scene.closest_point(points)
    a, b, c = np.moveaxis(np.concatenate(corners)[found.instance_id * 60 + found.prim_id], 1, 0)
    u, v = found.u[:, None], found.v[:, None]
    assert np.allclose((1 - u - v) * a + u * b + v * c, found.point, atol=1e-5)
    assert np.allclose(np.linalg.norm(found.point - points, axis=1), found.distance, rtol=1e-12)
    samples = rng.dirichlet((1, 1, 1), 40)
    on_surface = np.einsum("sk,tkx->stx", samples, np.concatenate(corners)).reshape(-1, 3)
    for point, distance in zip(points[:200], found.distance[:200], strict=True):
        assert np.linalg.norm(on_surface - point, axis=1).min() >= distance - 1e-9


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((np.zeros((2, 2)),), "points"),
        ((np.zeros((2, 3), np.int64),), "points"),
        ((np.zeros((2, 3)), -1.0), "max_distance"),
        ((np.zeros((2, 3)), float("nan")), "max_distance"),
        ((np.zeros((2, 3)), "far"), "max_distance"),
    ],
)
def test_wrong_arguments_are_named(scene: regraft.Scene, arguments: Any, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        scene.closest_point(*arguments)


def test_a_changed_scene_must_be_updated_first() -> None:
    scene = regraft.Scene(threads=1)
    scene.add_instance(scene.add_mesh(VERTICES, TRIANGLES))
    with pytest.raises(RuntimeError, match="update"):
        scene.closest_point(np.zeros((1, 3)))
