"""closest_hit and any_hit through the NumPy API: against brute force, and their arguments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import regraft
from api_shapes import MISS, affine, brute_force, moved, rays, soup, square
from regraft import _regraft

VERTICES, TRIANGLES = square()
FIELDS = ("t", "instance_id", "prim_id", "u", "v", "normal")
DOWN = np.array([[0.0, 0.0, -1.0]])


@pytest.fixture(scope="module")
def scene() -> regraft.Scene:
    """The square at z = 0 (instance 0) and mirrored at z = -1 (instance 1)."""
    scene = regraft.Scene(threads=2)
    mesh = scene.add_mesh(VERTICES, TRIANGLES)
    scene.add_instance(mesh)
    scene.add_instance(mesh, moved(z=-1) @ np.diag([-1.0, 1, 1, 1]))
    scene.update()
    return scene


def crowd(threads: int = 2, isa: str = "auto") -> tuple[regraft.Scene, Any]:
    """Five instances of two soups under affine matrices; and their world triangles, by ids."""
    rng = np.random.default_rng(11)
    scene = regraft.Scene(threads, isa=isa)
    world = []
    for _ in range(2):
        vertices, triangles = soup(rng, 40)
        scene.add_mesh(vertices, triangles)
        world.append(vertices[triangles].astype(float))
    placed = []
    for i in range(5):
        matrix = affine(rng)
        scene.add_instance(i % 2, matrix)
        placed.append(world[i % 2] @ matrix[:3, :3].T + matrix[:3, 3])
    scene.update()
    return scene, np.concatenate(placed)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_hits_equal_brute_force(dtype: type) -> None:
    scene, triangles = crowd()
    origins, directions = np.stack(rays(np.random.default_rng(2), 1500)).astype(dtype)
    hits = scene.closest_hit(origins, directions)
    oracle = brute_force(triangles, origins.astype(float), directions.astype(float))
    sure = ~oracle.near_edge
    assert sure.mean() > 0.9, "the oracle decides most rays"
    assert 0.2 < np.isfinite(oracle.t).mean() < 0.95, "some rays hit, some miss"
    hit = np.isfinite(oracle.t) & sure
    number = hits.instance_id[hit].astype(int) * 40 + hits.prim_id[hit]
    assert np.array_equal(number, oracle.triangle[hit])
    assert np.allclose(hits.t[hit], oracle.t[hit], rtol=1e-4, atol=1e-4)
    missed = ~np.isfinite(oracle.t) & sure
    assert (hits.instance_id[missed] == MISS).all()
    assert np.array_equal(scene.any_hit(origins, directions), np.isfinite(hits.t))


@pytest.mark.parametrize("layout", ["two-level", "flat"])
def test_trees_change_no_bit_of_a_hit(layout: str) -> None:
    scene, _ = crowd()
    scene.update(layout=layout)
    random = rays(np.random.default_rng(14), 2000)
    aimed = np.tile([[0.1, 0.2, 3.0]], (2000, 1)), np.random.default_rng(15).normal(size=(2000, 3))
    for batch in (random, aimed):
        got, want = scene.closest_hit(*batch), scene.closest_hit_brute_force(*batch)
        for name in FIELDS:
            assert np.array_equal(getattr(got, name), getattr(want, name)), name


def test_barycentrics_and_distance_name_the_same_point() -> None:
    scene, triangles = crowd()
    origins, directions = rays(np.random.default_rng(4), 2000)
    hits = scene.closest_hit(origins, directions)
    hit = np.isfinite(hits.t)
    a, b, c = np.moveaxis(
        triangles[hits.instance_id[hit].astype(int) * 40 + hits.prim_id[hit]], 1, 0
    )
    u, v = hits.u[hit, None], hits.v[hit, None]
    along = origins[hit] + directions[hit] * hits.t[hit, None]
    assert np.allclose((1 - u - v) * a + u * b + v * c, along, atol=1e-3)


def test_normals_face_as_the_placed_triangle_is_wound() -> None:
    scene, triangles = crowd()
    hits = scene.closest_hit(*rays(np.random.default_rng(6), 2000))
    hit = np.isfinite(hits.t)
    a, b, c = np.moveaxis(
        triangles[hits.instance_id[hit].astype(int) * 40 + hits.prim_id[hit]], 1, 0
    )
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.allclose(hits.normal[hit], normal, atol=1e-5)
    assert (hits.normal[~hit] == 0).all()


@pytest.mark.parametrize("scale", [1e-10, 1e-4, 1.0, 1e6])
def test_normals_are_unit_vectors_at_any_scale(scale: float) -> None:
    scene = regraft.Scene(threads=1)
    matrix = np.diag([scale, scale * 1e-3, scale, 1])
    scene.add_instance(scene.add_mesh(VERTICES * np.float32(1e-3), TRIANGLES), matrix)
    scene.update()
    hits = scene.closest_hit(np.array([[0, 0, scale]]), DOWN)
    assert np.allclose(hits.normal, [[0, 0, 1]], atol=1e-6)


def test_normals_of_flattened_instances_are_right() -> None:
    scene = regraft.Scene(threads=1)
    tilted = np.array([[-1, -1, 0], [1, -1, 1], [0, 1, 3]], np.float32)
    scene.add_instance(
        scene.add_mesh(tilted, np.array([[0, 1, 2]], np.uint32)), np.diag([1, 1, 0, 1.0])
    )
    scene.update()
    hits = scene.closest_hit(np.array([[0, 0, 1.0]]), DOWN)
    assert hits.instance_id[0] == 0
    assert np.allclose(hits.normal, [[0, 0, 1]])


def test_a_batch_has_the_promised_arrays(scene: regraft.Scene) -> None:
    hits = scene.closest_hit(np.array([[0, 0, 1.0], [9, 9, 1.0]]), np.tile(DOWN, (2, 1)))
    assert len(hits) == 2
    for name, dtype in {
        "t": "f4",
        "instance_id": "u4",
        "prim_id": "u4",
        "u": "f4",
        "v": "f4",
    }.items():
        array = getattr(hits, name)
        assert (array.dtype, array.shape) == (np.dtype(dtype), (2,)), name
        assert array.flags.c_contiguous, name
        assert array.flags.writeable, name
    assert hits.normal.shape == (2, 3)
    assert (hits.t[1], hits.instance_id[1], hits.prim_id[1]) == (np.inf, MISS, MISS)
    assert (hits.u[1], hits.v[1]) == (0, 0)


def test_results_outlive_the_batch_and_the_scene() -> None:
    scene, _ = crowd()
    t = scene.closest_hit(*rays(np.random.default_rng(8), 100)).t
    kept = t.copy()
    del scene
    assert np.array_equal(t, kept)


@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 256, 257, 5000])
def test_batches_of_any_size_are_complete(scene: regraft.Scene, count: int) -> None:
    rng = np.random.default_rng(count)
    origins = np.c_[rng.uniform(-2, 2, (count, 2)), np.ones(count)]
    hits = scene.closest_hit(origins, np.tile(DOWN, (count, 1)))
    inside = (np.abs(origins[:, :2]) <= 1).all(1)
    assert np.array_equal(np.isfinite(hits.t), inside)
    assert np.array_equal(scene.any_hit(origins, np.tile(DOWN, (count, 1))), inside)


def test_memory_layout_and_precision_of_rays_do_not_matter() -> None:
    scene, _ = crowd()
    origins, directions = np.stack(rays(np.random.default_rng(9), 777)).astype(np.float32)
    want = scene.closest_hit(origins, directions).t
    padded = np.zeros((777, 9), np.float64)[:, ::3]
    padded[:] = origins
    packed: Any = np.ndarray((777, 3), np.float32, bytearray(777 * 13), 1, (13, 4))
    packed[:] = directions
    for o, d in (
        (origins.astype(float), directions),
        (np.asfortranarray(origins), np.asfortranarray(directions)),
        (padded, packed),
    ):
        assert np.array_equal(scene.closest_hit(o, d).t, want)
    assert np.array_equal(scene.closest_hit(origins[::-1], directions[::-1]).t[::-1], want)


def test_one_ray_may_be_broadcast(scene: regraft.Scene) -> None:
    origins = np.broadcast_to(np.array([0.1, 0.1, 1.0]), (1000, 3))
    assert scene.any_hit(origins, np.broadcast_to(DOWN, (1000, 3))).all()


def test_limits_are_numbers_or_one_a_ray(scene: regraft.Scene) -> None:
    origins, directions = np.tile([[0.1, 0.2, 1.0]], (3, 1)), np.tile(DOWN, (3, 1))
    near = np.array([0, 1.5, 0], np.float32)
    far = np.array([5, 5, 0.5], np.float32)
    hits = scene.closest_hit(origins, directions, near, far)
    assert hits.instance_id.tolist() == [0, 1, MISS]
    assert scene.any_hit(origins, directions, near, far).tolist() == [True, True, False]
    assert scene.closest_hit(origins, directions, 1.5).instance_id.tolist() == [1, 1, 1]
    assert scene.closest_hit(origins, directions, t_far=0.5).instance_id.tolist() == [MISS] * 3
    assert scene.closest_hit(origins, directions, float(np.float64(0.5)), 7).instance_id[0] == 0


def test_distances_are_in_units_of_the_direction(scene: regraft.Scene) -> None:
    for length in (1e-30, 0.5, 4.0, 1e30):
        hits = scene.closest_hit(np.array([[0.1, 0.2, 1.0]]), DOWN * length)
        assert hits.t[0] == pytest.approx(1 / length, rel=1e-5)


@pytest.mark.parametrize("count", [1, 200])
def test_rays_without_direction_or_with_nan_miss(scene: regraft.Scene, count: int) -> None:
    origins, directions = np.tile([[0.1, 0.2, 1.0]], (count, 1)), np.tile(DOWN, (count, 1))
    for bad in ([0, 0, 0], [np.nan, 0, -1], [0, np.inf, -1]):
        directions[0] = bad
        assert scene.closest_hit(origins, directions).instance_id.tolist() == [MISS] + [0] * (
            count - 1
        )
        assert scene.any_hit(origins, directions).tolist() == [False] + [True] * (count - 1)
    for bad in ([np.nan, 0, 1], [0, -np.inf, 1]):
        assert scene.closest_hit(np.array([bad]), DOWN).t[0] == np.inf
    for near, far in ((np.nan, 9.0), (0.0, np.nan), (3.0, 2.0)):
        assert scene.closest_hit(origins[:1], DOWN, near, far).t[0] == np.inf


def test_ties_go_to_the_lowest_instance_and_triangle() -> None:
    scene = regraft.Scene(threads=1)
    double = np.concatenate([TRIANGLES, TRIANGLES])
    scene.add_mesh(VERTICES, double)
    scene.add_instances(np.zeros(6, np.uint32), np.stack([np.eye(4)] * 6))
    scene.remove_instance(0)
    scene.update()
    rng = np.random.default_rng(3)
    origins = np.c_[rng.uniform(-0.9, 0.9, (500, 2)), np.ones(500)]
    hits = scene.closest_hit(origins, np.tile(DOWN, (500, 1)))
    assert (hits.instance_id == 1).all()
    assert (hits.prim_id < 2).all()


@pytest.mark.parametrize("isa", _regraft.available_isas())
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_results_do_not_depend_on_threads_or_instruction_set(threads: int, isa: str) -> None:
    reference, _ = crowd(1, "scalar")
    scene, _ = crowd(threads, isa)
    random = rays(np.random.default_rng(12), 3000)
    towards = np.array([[0.0, 0.0, 3.0]]) + np.zeros((3000, 1))
    aimed = np.random.default_rng(13).uniform(-1, 1, (3000, 3)) - towards
    for origins, directions in (random, (towards, aimed)):
        want = reference.closest_hit(origins, directions)
        got = scene.closest_hit(origins, directions)
        for name in FIELDS:
            assert np.array_equal(getattr(got, name), getattr(want, name)), name


def test_large_batches_are_complete() -> None:
    """Beyond the size at which the calling thread only watches."""
    scene = regraft.Scene(threads=2)
    scene.add_instance(scene.add_mesh(VERTICES, TRIANGLES))
    scene.update()
    count = 300_001
    origins = np.broadcast_to(np.array([0.1, 0.2, 1.0], np.float32), (count, 3))
    directions = np.broadcast_to(DOWN, (count, 3))
    assert scene.any_hit(origins, directions).sum() == count
    assert (scene.closest_hit(origins, directions).instance_id == 0).sum() == count


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 0, 1]], DOWN), "origins: a NumPy array of float32 or float64 wanted, got list"),
        ((np.zeros((1, 3), int), DOWN), "origins: float32 or float64 wanted, got int64"),
        ((np.zeros((1, 3), np.float16), DOWN), "origins: float32 or float64 wanted, got float16"),
        ((np.zeros(3), DOWN), r"origins: shape \(N, 3\) wanted, got \(3,\)"),
        ((np.zeros((2, 3)), DOWN), r"directions: shape \(2, 3\) wanted, got \(1, 3\)"),
        ((DOWN, DOWN, np.zeros(1)), "t_near: float32 wanted, got float64"),
        ((DOWN, DOWN, 0, np.zeros(2, np.float32)), r"t_far: shape \(1,\) wanted, got \(2,\)"),
        ((DOWN, DOWN, "near"), "t_near: a number wanted, got str"),
        ((DOWN, DOWN, 0, None), "t_far: a number wanted, got NoneType"),
    ],
)
def test_wrong_rays_are_named(
    scene: regraft.Scene, arguments: tuple[Any, ...], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        scene.closest_hit(*arguments)
    with pytest.raises(ValueError, match=message):
        scene.any_hit(*arguments)


def test_the_order_of_a_large_batch_does_not_matter() -> None:
    scene, _ = crowd()
    rng = np.random.default_rng(5)
    origins, directions = rays(rng, 20_000)
    origins[7, 1], directions[9] = np.nan, 0.0
    near = rng.random(20_000).astype(np.float32)
    hits = scene.closest_hit(origins, directions, near)
    any_hit = scene.any_hit(origins, directions, near)
    for part in np.split(np.arange(20_000), 4):  # too few to be put in order
        alone = scene.closest_hit(origins[part], directions[part], near[part])
        for field in FIELDS:
            assert np.array_equal(getattr(hits, field)[part], getattr(alone, field)), field
        assert np.array_equal(
            any_hit[part], scene.any_hit(origins[part], directions[part], near[part])
        )
    assert 0.2 < any_hit.mean() < 0.95
