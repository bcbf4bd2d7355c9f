"""The policy that plans for a whole shot, and the key frames that it needs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import regraft
from regraft import Camera
from regraft.study import key_frames
from regraft.study.planned_scene import PlannedScene
from regraft.study.shot import Call, Shot, ShotWriter

TRIANGLES = np.arange(30, dtype=np.uint32).reshape(-1, 3)


def points(frame: int) -> np.ndarray:
    random = np.random.default_rng(1)
    start, step = random.random((10, 1, 3)), random.normal(size=(10, 1, 3))
    shape = 0.05 * random.random((10, 3, 3))
    placed: np.ndarray = (start + frame * step + shape).reshape(-1, 3).astype(np.float32)
    return placed


def moved(frame: int) -> np.ndarray:
    matrix = np.eye(4)
    matrix[0, 3] = frame
    return matrix


@pytest.fixture
def shot(tmp_path: Path) -> Shot:
    camera = Camera.perspective(np.eye(4), 50.0, 1.0)
    with ShotWriter(tmp_path) as writer:
        writer.add_call("add_mesh", (points(0), TRIANGLES), {})
        writer.add_call("add_instance", (0, np.eye(4)), {})
        for frame in range(20):
            if frame:
                writer.add_call("set_vertices", (0, points(frame)), {})
                writer.add_call("set_transform", (0, moved(frame)), {})
            writer.end_frame(frame, camera)
    return Shot(tmp_path)


@pytest.mark.parametrize("layout", ["two-level", "flat"])
def test_a_planned_shot_hits_what_every_other_policy_hits(shot: Shot, layout: str) -> None:
    planned, rebuilt = regraft.Scene(threads=1), regraft.Scene(threads=1)
    rays = np.random.default_rng(2).normal(size=(2, 500, 3))
    for position in range(len(shot)):
        for scene in (planned, rebuilt):
            shot.apply(position, scene)
        key_frames.give(shot, planned, position)
        assert planned.update(policy="shot", layout=layout).policy == "shot"
        rebuilt.update(policy="rebuild", layout=layout)
        hits, others = (s.closest_hit(10 * rays[0], rays[1]) for s in (planned, rebuilt))
        assert np.array_equal(hits.prim_id, others.prim_id)
        assert np.array_equal(hits.t, others.t)
    assert planned.quality(fresh=True)["cost_ratio"] < 3.0


def keys_of(shot: Shot, folder: Path) -> Shot:
    """A shot of the key frames only, as if the others had not been looked at."""
    wanted = key_frames.spread(shot.frames)
    with ShotWriter(folder) as writer:
        for position, frame in enumerate(shot.frames):
            for call in shot.edits(position):
                writer.add_call(*call)
            if frame in wanted:
                writer.end_frame(frame, shot.camera(position))
    return Shot(folder)


def test_a_planned_scene_is_built_once_for_all_of_a_shot(shot: Shot, tmp_path: Path) -> None:
    (tmp_path / "keys").mkdir()
    planned = PlannedScene(regraft.Scene(threads=1), keys_of(shot, tmp_path / "keys"))
    rebuilt = regraft.Scene(threads=1)
    rays = np.random.default_rng(2).normal(size=(2, 500, 3))
    for position in range(len(shot)):
        for scene in (planned, rebuilt):
            shot.apply(position, scene)
        done = planned.update(policy="refit", frames_left=3)
        rebuilt.update(policy="rebuild")
        assert done.policy == "shot"
        assert (done.nodes_rebuilt > 0) == (position == 0)
        hits, others = (s.closest_hit(10 * rays[0], rays[1]) for s in (planned, rebuilt))
        assert np.array_equal(hits.prim_id, others.prim_id)
    assert planned.quality(fresh=True)["cost_ratio"] < 3.0


def test_a_planned_scene_takes_what_is_new_or_moves_between_key_frames_only(tmp_path: Path) -> None:
    camera = Camera.perspective(np.eye(4), 50.0, 1.0)
    edits: list[Call] = [
        ("add_mesh", (points(0), TRIANGLES), {}),
        ("add_instance", (0, np.eye(4)), {}),
    ]
    with ShotWriter(tmp_path) as writer:
        for edit in edits:
            writer.add_call(*edit)
        writer.end_frame(1, camera)
    scene = PlannedScene(regraft.Scene(threads=1), Shot(tmp_path))
    for name, args, kwargs in edits:
        getattr(scene, name)(*args, **kwargs)
    scene.update()
    new = scene.add_instance(scene.add_mesh(points(1), TRIANGLES))
    scene.update()
    for mesh, instance in ((0, 0), (1, new)):
        scene.set_vertices(mesh, points(2))
        scene.set_transform(instance, moved(2))
    assert scene.update().moved_instances == 2
    with pytest.raises(ValueError, match="mesh 1 gets other triangles"):
        scene.set_mesh(1, points(1), TRIANGLES)


def test_what_moves_without_key_frames_is_named() -> None:
    scene = regraft.Scene(threads=1)
    mesh = scene.add_mesh(points(0), TRIANGLES, name="Debris")
    instance = scene.add_instance(mesh, name="Debris.001")
    scene.update(policy="shot")
    scene.set_vertices(mesh, points(1))
    with pytest.raises(ValueError, match=r'mesh 0 "Debris" moves.*set_key_vertices'):
        scene.update(policy="shot")
    scene.update(policy="refit")
    scene.set_transform(instance, moved(1))
    with pytest.raises(ValueError, match=r"Debris.001.*set_key_transforms"):
        scene.update(policy="shot")


def test_key_frames_must_fit_their_mesh() -> None:
    scene = regraft.Scene(threads=1)
    mesh = scene.add_mesh(points(0), TRIANGLES)
    with pytest.raises(ValueError, match="29 vertices, 30 wanted"):
        scene.set_key_vertices(mesh, np.zeros((2, 29, 3), np.float32))
    with pytest.raises(ValueError, match="frames"):
        scene.set_key_vertices(mesh, np.zeros((30, 3), np.float32))
    with pytest.raises(ValueError, match="instance 0"):
        scene.set_key_transforms(0, np.eye(4)[None])
