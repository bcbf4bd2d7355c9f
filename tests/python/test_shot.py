"""A shot replayed is the shot recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import regraft
from regraft.study import local_motion
from regraft.study.shot import INDEX, Recorder, Shot, ShotWriter

TRIANGLES = np.array([[0, 1, 2], [2, 1, 3]], np.uint32)
VERTICES = np.array([[-1, 0, -1], [1, 0, -1], [-1, 0, 1], [1, 0, 1]], np.float32)
Picture = npt.NDArray[np.float32]


def camera(distance: float) -> regraft.Camera:
    """Looks along +Y at the square from `distance` metres."""
    matrix = np.array([[1, 0, 0, 0], [0, 0, -1, -distance], [0, 1, 0, 0], [0, 0, 0, 1]], float)
    return regraft.Camera.perspective(matrix, 50, 1.0)


def film(folder: Path) -> list[Picture]:
    """Records three frames that use every kind of edit; their pictures."""
    with ShotWriter(folder) as writer:
        scene = Recorder(regraft.Scene(threads=1), writer)
        group = scene.add_group(name="all")
        scene.set_materials(np.array([[0.8, 0.2, 0.1, 1], [0.1, 0.9, 0.3, 1]], np.float32))
        mesh = scene.add_mesh(VERTICES, TRIANGLES, slots=np.array([0, 1], np.uint16))
        lone = scene.add_instance(mesh, np.eye(4), group=group, materials=(1, 0))
        pair = scene.add_instances(
            np.array([mesh, mesh], np.uint32),
            np.stack([np.diag([0.5, 1, 1, 1]), np.diag([1, 1, 0.5, 1])]),
            materials=[(0, 1), (1,)],
        )
        scene.set_lights([regraft.Light("sun", direction=(0.2, 1, -0.5), energy=2.0)])
        scene.set_world((0.1, 0.2, 0.3))
        pictures = [shoot(scene, 1, camera(4.0))]
        moved = np.eye(4)
        moved[:3, 3] = 0.7, 0.5, 0.2
        scene.set_transform(lone, moved)
        scene.set_vertices(mesh, VERTICES * np.float32(1.5))
        scene.set_visible(int(pair[0]), False)
        pictures.append(shoot(scene, 5, camera(5.0)))
        scene.remove_instance(int(pair[1]))
        scene.set_instance_materials(lone, (0,))
        pictures.append(shoot(scene, 6, camera(5.0)))
    return pictures


def shoot(scene: Recorder, frame: int, seen: regraft.Camera) -> Picture:
    scene.next_frame = frame
    scene.update()
    picture: Picture = scene.render(seen, 24, 24).passes["combined"]
    return picture


def test_a_replayed_shot_gives_the_same_pictures(tmp_path: Path) -> None:
    pictures = film(tmp_path)
    shot, scene = Shot(tmp_path), regraft.Scene(threads=2)
    assert shot.frames == (1, 5, 6)
    for position, picture in enumerate(pictures):
        shot.apply(position, scene)
        scene.update(policy="rebuild", layout="flat")
        replayed = scene.render(shot.camera(position), 24, 24).passes["combined"]
        assert np.array_equal(replayed, picture)
    assert len({picture.tobytes() for picture in pictures}) == 3


def test_edits_can_be_left_out(tmp_path: Path) -> None:
    film(tmp_path)
    shot, scene = Shot(tmp_path), regraft.Scene(threads=1)
    shot.apply(0, scene, leave_out=frozenset({"set_world"}))
    scene.set_world((0.7, 0.7, 0.7))
    scene.update()
    corner = scene.render(shot.camera(0), 24, 24).passes["combined"][0, 0, :3]
    assert np.array_equal(corner, np.array([0.7, 0.7, 0.7], np.float32)), (
        "the recorded world came through"
    )


def test_an_interrupted_recording_is_no_shot(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), ShotWriter(tmp_path) as writer:
        writer.add_call("set_world", (1 / 0,), {})
    assert not (tmp_path / INDEX).exists()
    with pytest.raises(FileNotFoundError):
        Shot(tmp_path)


def test_a_refused_edit_is_not_written_down(tmp_path: Path) -> None:
    with ShotWriter(tmp_path) as writer:
        scene = Recorder(regraft.Scene(threads=1), writer)
        with pytest.raises(ValueError, match="mesh"):
            scene.set_vertices(3, VERTICES)
        writer.end_frame(1, camera(4.0))
    assert Shot(tmp_path).edits(0) == []


def test_local_motion_moves_only_its_part(tmp_path: Path) -> None:
    shot = local_motion.make(tmp_path, 20_000, 2_000, 4)
    (_, (points, faces), _), _ = shot.edits(0)
    assert abs(len(faces) - 20_000) < 400
    assert faces.max() == len(points) - 1
    still = len(points) - 6_000
    for position in (1, 2, 3):
        ((name, (mesh, moved), _),) = shot.edits(position)
        assert (name, mesh) == ("set_vertices", 0)
        assert np.array_equal(moved[:still], points[:still])
        assert (moved[still:] != points[still:]).any(axis=1).mean() > 0.9
    scene = regraft.Scene(threads=1)
    shot.apply(0, scene)
    scene.update()
    seen = scene.render(shot.camera(0), 48, 48, passes=("combined", "depth")).passes["depth"]
    assert 0.2 < np.isfinite(seen).mean() < 1.0, "the landscape is framed"
