"""What `update` does and says, and that an updated scene equals one built fresh."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import regraft
from api_shapes import affine, moved, rays, soup, square

VERTICES, TRIANGLES = square()

UPDATE_FIELDS = [
    *("update_ms", "policy", "structure", "layout", "triangles", "instances", "moved_instances"),
    *("deformed_meshes", "deformed_triangles", "nodes", "nodes_refitted", "nodes_rebuilt"),
    *("pairs_considered", "pairs_restructured", "late_updates", "late_update_ms"),
    *("culling_efficiency", "cost_ratio"),
    *("kdtree_nodes", "kdtree_built_fraction", "kdtree_unbuilt_nodes", "kdtree_large_leaves"),
    *("memory_bytes", "left_out", "warnings"),
]
QUALITY_FIELDS = [
    "sah_cost",
    "culling_efficiency",
    "epo",
    "origin_cost",
    "cost_ratio",
    "depth",
    "bytes",
]


@pytest.fixture
def scene() -> regraft.Scene:
    """Two meshes of 200 triangles with two instances each, up to date."""
    rng = np.random.default_rng(1)
    scene = regraft.Scene(threads=2)
    for _ in range(2):
        mesh = scene.add_mesh(*soup(rng, 200))
        scene.add_instance(mesh)
        scene.add_instance(mesh, moved(x=3))
    scene.update()
    return scene


def jittered(seed: int) -> Any:
    return soup(np.random.default_rng(seed), 200)[0]


def test_the_first_update_builds(scene: regraft.Scene) -> None:
    fresh = regraft.Scene(threads=1)
    fresh.add_instance(fresh.add_mesh(VERTICES, TRIANGLES))
    statistics = fresh.update()
    assert statistics.nodes_rebuilt > 0
    assert (statistics.triangles, statistics.instances) == (2, 1)
    assert statistics.memory_bytes > VERTICES.nbytes + TRIANGLES.nbytes


def test_an_update_without_changes_does_nothing(scene: regraft.Scene) -> None:
    statistics = scene.update()
    assert (statistics.nodes_refitted, statistics.nodes_rebuilt) == (0, 0)
    assert statistics.left_out == ["nothing changed: no update"]
    assert statistics.triangles == 800


def test_an_update_of_an_empty_scene_is_legal() -> None:
    scene = regraft.Scene(threads=1)
    assert scene.update().triangles == 0
    assert not scene.any_hit(np.zeros((3, 3)), np.ones((3, 3))).any()
    with pytest.raises(ValueError, match="bounds: the scene has nothing that can be hit"):
        scene.bounds()


def test_a_deformation_refits_only_its_mesh(scene: regraft.Scene) -> None:
    scene.set_vertices(1, jittered(9))
    statistics = scene.update("refit")
    assert (statistics.deformed_meshes, statistics.deformed_triangles) == (1, 200)
    assert 0 < statistics.nodes_refitted < statistics.nodes
    assert statistics.nodes_rebuilt == 0
    assert statistics.policy == "refit"


def test_policy_rebuild_rebuilds(scene: regraft.Scene) -> None:
    scene.set_vertices(1, jittered(9))
    statistics = scene.update("rebuild")
    assert statistics.nodes_rebuilt > 0
    assert statistics.policy == "rebuild"


def test_a_moved_instance_touches_no_mesh(scene: regraft.Scene) -> None:
    scene.set_transform(1, moved(x=4))
    statistics = scene.update("refit")
    assert (statistics.moved_instances, statistics.deformed_meshes) == (1, 0)
    assert statistics.nodes_refitted < 10


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.set_transform(1, moved(x=3)),
        lambda s: s.set_transforms([0, 1], np.stack([np.eye(4), moved(x=3)])),
        lambda s: s.set_vertices(0, soup(np.random.default_rng(1), 200)[0]),
        lambda s: s.set_visible(0, True),
        lambda s: s.remove_mesh(s.add_mesh(VERTICES, TRIANGLES)),
        lambda s: s.set_materials(np.ones((1, 4), np.float32)),
        lambda s: s.set_lights([regraft.Light("sun")]),
        lambda s: s.set_world((1, 1, 1)),
        lambda s: s.set_instance_materials(0, (0,)),
        lambda s: s.add_group(),
    ],
)
def test_what_rays_cannot_notice_is_no_change(
    scene: regraft.Scene, change: Callable[[regraft.Scene], object]
) -> None:
    change(scene)
    assert len(scene.closest_hit(np.zeros((1, 3)), np.ones((1, 3)))) == 1, "not stale"
    statistics = scene.update()
    assert (statistics.nodes_refitted, statistics.nodes_rebuilt) == (0, 0)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.add_instance(0),
        lambda s: s.remove_instance(0),
        lambda s: s.set_visible(0, False),
        lambda s: s.set_transform(0, moved(x=1)),
        lambda s: s.set_vertices(0, jittered(2)),
        lambda s: s.set_mesh(0, VERTICES, TRIANGLES),
        lambda s: s.add_mesh(VERTICES, TRIANGLES),
    ],
)
@pytest.mark.parametrize(
    "trace",
    [
        lambda s: s.closest_hit(np.zeros((1, 3)), np.ones((1, 3))),
        lambda s: s.any_hit(np.zeros((0, 3)), np.ones((0, 3))),
        lambda s: s.render(regraft.Camera.perspective(np.eye(4), 50, 1), 8, 8),
        lambda s: s.bounds(),
        lambda s: s.quality(),
    ],
)
def test_tracing_a_changed_scene_raises_until_it_is_updated(
    scene: regraft.Scene,
    change: Callable[[regraft.Scene], object],
    trace: Callable[[regraft.Scene], object],
) -> None:
    change(scene)
    with pytest.raises(RuntimeError, match="changed since its last update"):
        trace(scene)
    scene.update()
    trace(scene)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"policy": "best"}, 'policy: "best" is none of auto, refit, rebuild'),
        ({"structure": "octree"}, 'structure: "octree" is none of auto, bvh, kdtree'),
        ({"layout": "round"}, 'layout: "round" is none of two-level, flat'),
        ({"frames_left": 0}, "frames_left: 0 is outside"),
        ({"frames_left": "many"}, "frames_left: a whole number wanted, got str"),
    ],
)
def test_wrong_update_arguments_are_named(
    scene: regraft.Scene, arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        scene.update(**arguments)


def test_layouts_are_switched_without_another_change(scene: regraft.Scene) -> None:
    assert scene.update(layout="flat").layout == "flat"
    assert scene.update(layout="two-level", frames_left=10).layout == "two-level"


def test_nearest_points_and_quality_are_there_with_a_kdtree(scene: regraft.Scene) -> None:
    points = np.random.default_rng(6).normal(size=(50, 3))
    scene.update(structure="bvh")
    wanted = scene.closest_point(points)
    scene.update(structure="kdtree")
    found = scene.closest_point(points)
    np.testing.assert_array_equal(found.distance, wanted.distance)
    np.testing.assert_array_equal(found.prim_id, wanted.prim_id)
    quality = scene.quality(fresh=True)
    assert quality["sah_cost"] > 0.0
    assert quality["depth"] > 0
    assert (quality["epo"], quality["cost_ratio"]) == (0.0, 1.0)
    assert 0.0 < quality["kdtree_q"] < 1.0


def test_auto_builds_a_kdtree_where_little_of_a_large_scene_is_in_view() -> None:
    side = 708
    x, y = np.meshgrid(np.arange(side + 1), np.arange(side + 1))
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1, 1)
    right, above = corner + 1, corner + side + 1
    triangles = np.concatenate(
        [np.hstack([corner, right, above]), np.hstack([right, above + 1, above])]
    ).astype(np.uint32)
    for distance, structure in ((10.0, "kdtree"), (2000.0, "bvh")):
        large = regraft.Scene(1)
        large.add_instance(large.add_mesh(vertices, triangles))
        matrix = np.eye(4)
        matrix[:3, 3] = side / 2, side / 2, distance
        camera = regraft.Camera("perspective", matrix)
        statistics = large.update(frames_left=1, camera=camera)
        assert statistics.structure == structure
        assert any("triangles in view" in text for text in statistics.left_out)


def test_a_kdtree_is_built_where_rays_go_and_hits_the_same(scene: regraft.Scene) -> None:
    origins, directions = rays(np.random.default_rng(5), 200)
    wanted = scene.closest_hit(origins, directions)
    statistics = scene.update(structure="kdtree")
    assert statistics.structure == "kdtree"
    assert (statistics.kdtree_nodes, statistics.kdtree_built_fraction) == (0, 0.0)
    assert (statistics.kdtree_unbuilt_nodes, statistics.kdtree_large_leaves) == (1, 0)
    for _ in range(2):
        found = scene.closest_hit(origins, directions)
        for name in ("t", "instance_id", "prim_id", "u", "v", "normal"):
            np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))
    brute = scene.closest_hit_brute_force(origins, directions)
    np.testing.assert_array_equal(brute.t, wanted.t)
    scene.set_vertices(1, jittered(3))
    scene.update(structure="kdtree")
    moved_hits = scene.closest_hit(origins, directions)
    scene.update(structure="bvh")
    np.testing.assert_array_equal(moved_hits.t, scene.closest_hit(origins, directions).t)


def test_statistics_become_plain_json_in_their_order(scene: regraft.Scene) -> None:
    statistics = scene.update()
    line = statistics.as_dict()
    assert list(line) == UPDATE_FIELDS
    assert json.loads(json.dumps(line)) == line
    assert {name: getattr(statistics, name) for name in UPDATE_FIELDS} == line


def test_statistics_can_be_written_and_appended_to(scene: regraft.Scene) -> None:
    statistics = scene.update()
    statistics.update_ms = 2.5
    statistics.warnings.append("careful")
    line = statistics.as_dict()
    line["warnings"].append("of the copy only")
    assert (statistics.update_ms, statistics.warnings) == (2.5, ["careful"])
    with pytest.raises(TypeError):
        statistics.triangles = "many"  # type: ignore[assignment]


def test_triangles_that_cannot_be_hit_are_counted_and_named() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 0, 1]], np.uint32)
    scene = regraft.Scene(threads=1)
    scene.add_instance(scene.add_mesh(vertices, triangles, name="Rag"))
    warnings = scene.update().warnings
    assert any("Rag" in w and "1 triangles with non-finite" in w for w in warnings)
    assert any("1 triangles of zero area" in w for w in warnings)


def test_an_instance_with_a_nan_matrix_is_dropped_with_a_warning(scene: regraft.Scene) -> None:
    scene.set_transform(0, np.full((4, 4), np.nan))
    statistics = scene.update()
    assert statistics.instances == 3
    assert any("instance 0" in warning for warning in statistics.warnings)


def test_quality_says_what_it_promises(scene: regraft.Scene) -> None:
    quality = scene.quality()
    assert list(quality) == [
        "sah_cost",
        "culling_efficiency",
        "epo",
        "origin_cost",
        "cost_ratio",
        "depth",
        "bytes",
    ]
    assert quality["sah_cost"] > 0
    assert quality["origin_cost"] > 1
    assert scene.quality(fresh=True)["cost_ratio"] == pytest.approx(1.0)


def test_quality_compares_a_worn_tree_with_a_fresh_one(scene: regraft.Scene) -> None:
    scene.set_vertices(0, jittered(77))
    scene.update("refit")
    assert scene.quality(fresh=True)["cost_ratio"] > 1.05


def random_change(scene: regraft.Scene, rng: np.random.Generator, state: dict[str, Any]) -> None:
    """One change of a scene whose live ids and mesh sizes are in `state`."""
    kind = rng.integers(7)
    mesh = int(rng.choice(list(state["meshes"])))
    instance = int(rng.choice(list(state["instances"])))
    if kind == 0:
        arrays = soup(rng, int(rng.integers(1, 60)))
        new = scene.add_mesh(*arrays)
        state["meshes"][new] = arrays
    elif kind == 1:
        arrays = (soup(rng, len(state["meshes"][mesh][1]))[0], state["meshes"][mesh][1])
        scene.set_vertices(mesh, arrays[0])
        state["meshes"][mesh] = arrays
    elif kind == 2:
        arrays = soup(rng, int(rng.integers(0, 60)))
        scene.set_mesh(mesh, *arrays)
        state["meshes"][mesh] = arrays
    elif kind == 3:
        matrix = affine(rng)
        state["instances"][scene.add_instance(mesh, matrix)] = [mesh, matrix, True]
    elif kind == 4:
        state["instances"][instance][1] = affine(rng)
        scene.set_transform(instance, state["instances"][instance][1])
    elif kind == 5:
        state["instances"][instance][2] ^= True
        scene.set_visible(instance, state["instances"][instance][2])
    elif len(state["instances"]) > 1:
        scene.remove_instance(instance)
        del state["instances"][instance]


def built_fresh(state: dict[str, Any]) -> tuple[regraft.Scene, dict[int, int]]:
    """A new scene of the same content, and its instance ids by the old ones."""
    scene = regraft.Scene(threads=1, isa="scalar")
    meshes = {old: scene.add_mesh(*arrays) for old, arrays in state["meshes"].items()}
    ids = {}
    for old, (mesh, matrix, visible) in sorted(state["instances"].items()):
        ids[old] = scene.add_instance(meshes[mesh], matrix)
        scene.set_visible(ids[old], visible)
    scene.update("rebuild")
    return scene, ids


@pytest.mark.parametrize("layout", ["two-level", "flat"])
@pytest.mark.parametrize(
    "policy", ["auto", "refit", "rebuild", "lm", "rtdeform", "selective", "selective+rotate"]
)
@pytest.mark.parametrize("seed", range(4))
def test_after_random_changes_a_scene_hits_as_one_built_fresh(
    seed: int, policy: str, layout: str
) -> None:
    rng = np.random.default_rng(seed)
    scene = regraft.Scene(threads=2)
    arrays = soup(rng, 50)
    state: dict[str, Any] = {"meshes": {scene.add_mesh(*arrays): arrays}}
    state["instances"] = {scene.add_instance(0): [0, np.eye(4), True]}
    origins, directions = rays(rng, 400)
    for _ in range(12):
        for _ in range(rng.integers(1, 5)):
            random_change(scene, rng, state)
        scene.update(policy, layout=layout)
        fresh, ids = built_fresh(state)
        got = scene.closest_hit(origins, directions)
        want = fresh.closest_hit(origins, directions)
        known = np.vectorize(lambda i, table=ids: table.get(i, i), otypes=[np.uint32])
        assert np.array_equal(known(got.instance_id), want.instance_id)
        for name in ("t", "prim_id", "u", "v", "normal"):
            assert np.array_equal(getattr(got, name), getattr(want, name)), name
        assert np.array_equal(scene.any_hit(origins, directions), np.isfinite(want.t))


def looked_at_from_above(scene: regraft.Scene) -> Any:
    camera = regraft.Camera("perspective", moved(z=12), (-0.3, 0.3, -0.3, 0.3))
    return scene.render(camera, 96, 96, shading="clay").statistics


def flying_apart(policy: str) -> list[float]:
    """Tests a ray over ten frames in which 2,000 triangles fly apart above a wide ground."""
    rng = np.random.default_rng(5)
    corners = rng.uniform(-0.05, 0.05, (2000, 3, 3))
    start, speed = rng.uniform(-0.3, 0.3, (2, 2000, 1, 3))
    scene = regraft.Scene(threads=2)
    triangles = np.arange(6000, dtype=np.uint32).reshape(-1, 3)
    mesh = scene.add_mesh((start + corners).reshape(-1, 3).astype(np.float32), triangles)
    scene.add_instance(mesh)
    scene.add_instance(
        scene.add_mesh((VERTICES * [1000, 1000, 1] - [500, 500, 3]).astype(np.float32), TRIANGLES)
    )
    costs = []
    for frame in range(10):
        at = start + frame * speed + corners
        scene.set_vertices(mesh, at.reshape(-1, 3).astype(np.float32))
        scene.update(policy)
        costs.append(looked_at_from_above(scene).observed_cost)
    return costs


def test_damage_is_seen_however_wide_the_ground() -> None:
    fresh = flying_apart("rebuild")
    assert flying_apart("refit")[-1] > 4 * fresh[-1]
    assert max(flying_apart("auto")[5:]) < 3 * max(fresh)
