"""`regraft.KdTree`: hits of the scene, whatever it is built by; errors of its splits."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

import regraft
from api_shapes import rays, soup

BUILDS = ("eager", "scan", "hierarchy", "lazy+scan+hierarchy")


@pytest.fixture
def scene() -> regraft.Scene:
    found = regraft.Scene(threads=2)
    found.add_instance(found.add_mesh(*soup(np.random.default_rng(1), 2000, 0.05)))
    found.update(structure="kdtree")
    return found


def test_every_tree_hits_what_brute_force_hits(scene: regraft.Scene) -> None:
    origins, directions = rays(np.random.default_rng(2), 200)
    true = scene.closest_hit_brute_force(origins, directions)
    for build in BUILDS:
        for metric in ("sah", "regions6"):
            tree = regraft.KdTree(scene, build, metric=metric, origins=scene.bounds())
            found = tree.closest_hit(origins, directions)
            assert found.t.tobytes() == true.t.tobytes(), (build, metric)
            assert found.prim_id.tobytes() == true.prim_id.tobytes(), (build, metric)
            assert np.array_equal(tree.any_hit(origins, directions), np.isfinite(true.t))


def test_what_is_built_and_what_rays_take_is_counted(scene: regraft.Scene) -> None:
    origins, directions = rays(np.random.default_rng(3), 20)
    lazy, eager = regraft.KdTree(scene), regraft.KdTree(scene, "scan+hierarchy")
    assert lazy.statistics()["nodes"] == 0
    assert eager.statistics()["built_fraction"] == 1.0
    lazy.closest_hit(origins, directions)
    about = lazy.statistics()
    assert 0 < about["nodes"] < eager.statistics()["nodes"]
    assert about["nodes_visited"] > 0
    lazy.closest_hit(origins, directions)
    again = lazy.statistics()
    assert again["nodes"] == about["nodes"]
    assert again["nodes_visited"] >= 2 * about["nodes_visited"] * 0.9


def test_errors_of_splits_are_below_what_is_proven(scene: regraft.Scene) -> None:
    few, many, bound, exact = regraft.KdTree(scene).split_errors(
        [(inf, 1), (inf, 63), (0.03, 15), (0.0, 15)]
    )
    for errors in (few, many, bound, exact):
        assert errors["nodes_compared"] > 20
        assert errors["worst_excess"] <= errors["worst_certificate"] + 1e-12
        assert errors["mean_excess"] <= errors["worst_excess"]
    assert many["mean_excess"] < few["mean_excess"]
    assert bound["worst_excess"] <= 0.03
    assert abs(exact["worst_excess"]) < 1e-12


def test_rays_from_inside_want_another_metric(scene: regraft.Scene) -> None:
    inside = np.random.default_rng(4).uniform(-0.9, 0.9, (500, 3))
    tree = regraft.KdTree(scene)
    metric, box = tree.choose_metric(inside, (0.0, 0.0, 0.0))
    assert metric == "regions6"
    assert np.all(box[0] < -0.5)
    assert np.all(box[1] > 0.5)
    assert tree.choose_metric(inside + 10.0, (10.0, 0.0, 0.0))[0] == "sah"


def test_the_scene_cannot_change_under_a_tree(scene: regraft.Scene) -> None:
    tree = regraft.KdTree(scene)
    with pytest.raises(RuntimeError):
        scene.set_transform(0, np.diag([2.0, 1.0, 1.0, 1.0]))
    del tree
    scene.set_transform(0, np.diag([2.0, 1.0, 1.0, 1.0]))


def test_wrong_arguments_are_named(scene: regraft.Scene) -> None:
    for wrong, words in (
        ({"build": "quick"}, "build"),
        ({"metric": "best"}, "metric"),
        ({"samples": 14}, "samples"),
        ({"epsilon": -1.0}, "epsilon"),
        ({"origins": [1.0, 2.0]}, "origins"),
    ):
        with pytest.raises(ValueError, match=words):
            regraft.KdTree(scene, **wrong)  # type: ignore[arg-type]
    scene.update(structure="bvh")
    bvh = regraft.Scene(threads=1)
    bvh.update()
    with pytest.raises(ValueError, match="kdtree"):
        regraft.KdTree(bvh)
