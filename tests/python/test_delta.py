"""The delta and its mirror, against a recorder and against the real scene."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import regraft
from regraft_blender.sync.delta import (
    NONE,
    GroupData,
    IdMap,
    InstanceBatch,
    MaterialTable,
    MeshData,
    SceneDelta,
    SceneMirror,
)

TRIANGLE = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
CORNERS = np.array([[0, 1, 2]], np.uint32)


def triangle(name: str = "triangle") -> MeshData:
    return MeshData(name, TRIANGLE, CORNERS)


def handles(*numbers: int) -> np.ndarray[Any, np.dtype[np.uint32]]:
    return np.array(numbers, np.uint32)


def raised(*heights: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    transforms = np.tile(np.eye(4), (len(heights), 1, 1))
    transforms[:, 2, 3] = heights
    return transforms


def batch(numbers: tuple[int, ...], meshes: tuple[int, ...], *heights: float) -> InstanceBatch:
    return InstanceBatch(
        handles=handles(*numbers),
        meshes=handles(*meshes),
        transforms=raised(*heights),
        groups=handles(*[NONE] * len(numbers)),
        materials=[(0,)] * len(numbers),
        object_indices=handles(*range(len(numbers))),
    )


class Recorder:
    """A scene that hands out odd ids and keeps the names and arguments of all calls."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []

    def names(self) -> list[str]:
        return [call[0] for call in self.calls]

    def add_mesh(self, vertices: Any, triangles: Any, **more: Any) -> int:
        self.calls.append(("add_mesh", vertices, triangles, more))
        return 100 + self.names().count("add_mesh")

    def add_group(self, parent: int | None, *, name: str) -> int:
        self.calls.append(("add_group", parent, name))
        return 200 + self.names().count("add_group")

    def add_instances(self, meshes: Any, transforms: Any, **more: Any) -> Any:
        self.calls.append(("add_instances", meshes, transforms, more))
        return np.arange(300, 300 + len(meshes), dtype=np.uint32)

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **more: self.calls.append((name, *arguments, more))


def first_hit(scene: Any) -> Any:
    """What a ray from high above the origin meets."""
    scene.update()
    return scene.closest_hit(np.array([[0.0, 0.0, 100.0]]), np.array([[0.0, 0.0, -1.0]]))


def test_a_new_delta_is_empty() -> None:
    assert SceneDelta().is_empty()
    assert SceneDelta(left_out=["all"], warnings=["none"]).is_empty()


@pytest.mark.parametrize(
    "delta",
    [
        SceneDelta(groups=[GroupData(0, None, "g")]),
        SceneDelta(added_meshes={0: triangle()}),
        SceneDelta(retopologised={0: triangle()}),
        SceneDelta(deformed={0: TRIANGLE}),
        SceneDelta(removed_meshes=[0]),
        SceneDelta(added=batch((0,), (0,), 0.0)),
        SceneDelta(removed=handles(0)),
        SceneDelta(moved=handles(0), transforms=raised(1.0)),
        SceneDelta(hidden=handles(0)),
        SceneDelta(shown=handles(0)),
        SceneDelta(rematerialised={0: (1,)}),
        SceneDelta(lights=()),
        SceneDelta(world=(0.0, 0.0, 0.0)),
    ],
)
def test_every_kind_of_change_counts(delta: SceneDelta) -> None:
    assert not delta.is_empty()


def test_an_empty_delta_calls_nothing() -> None:
    recorder = Recorder()
    SceneMirror(recorder).apply(SceneDelta())
    assert recorder.calls == []


def test_handles_become_native_ids() -> None:
    recorder = Recorder()
    mirror = SceneMirror(recorder)
    mirror.apply(
        SceneDelta(
            groups=[GroupData(7, None, "top"), GroupData(3, 7, "below")],
            added_meshes={5: triangle("a"), 9: triangle("b")},
            added=InstanceBatch(
                handles=handles(4, 2),
                meshes=handles(9, 5),
                transforms=raised(1.0, 2.0),
                groups=handles(3, NONE),
                materials=[(0, 1), (2,)],
                object_indices=handles(11, 12),
            ),
        )
    )
    assert recorder.calls[:2] == [("add_group", None, "top"), ("add_group", 201, "below")]
    name, meshes, transforms, more = recorder.calls[-1]
    assert name == "add_instances"
    assert meshes.tolist() == [102, 101]
    assert transforms[:, 2, 3].tolist() == [1.0, 2.0]
    assert more["groups"].tolist() == [202, NONE]
    assert more["materials"] == [(0, 1), (2,)]
    assert more["object_indices"].tolist() == [11, 12]
    recorder.calls.clear()
    mirror.apply(SceneDelta(moved=handles(2, 4), transforms=raised(3.0, 4.0), hidden=handles(4)))
    assert recorder.calls[0][1].tolist() == [301, 300]
    assert recorder.calls[1][:3] == ("set_visible", 300, False)


def test_instances_go_before_their_mesh_and_come_after_it() -> None:
    recorder = Recorder()
    mirror = SceneMirror(recorder)
    mirror.apply(SceneDelta(added_meshes={0: triangle()}, added=batch((0,), (0,), 0.0)))
    mirror.apply(
        SceneDelta(
            added_meshes={1: triangle()},
            removed_meshes=[0],
            removed=handles(0),
            added=batch((1,), (1,), 0.0),
        )
    )
    names = recorder.names()[2:]
    assert names == ["add_mesh", "remove_instances", "add_instances", "remove_mesh"]


def test_ids_are_kept_beyond_the_first_sixteen_handles() -> None:
    ids = IdMap()
    ids.set(handles(1, 40), handles(8, 9))
    ids.set(100, 10)
    assert ids[handles(40, 1, 100)].tolist() == [9, 8, 10]
    ids.set(handles(), handles())


def test_an_id_that_was_never_set_is_refused_by_the_scene() -> None:
    mirror = SceneMirror(regraft.Scene())
    with pytest.raises(ValueError, match="instance"):
        mirror.apply(SceneDelta(moved=handles(3), transforms=raised(1.0)))


def test_a_real_scene_follows_every_kind_of_change() -> None:
    scene = regraft.Scene(threads=1)
    mirror = SceneMirror(scene)
    mirror.apply(
        SceneDelta(
            added_meshes={0: triangle(), 1: triangle()},
            added=batch((0, 1), (0, 1), 1.0, 2.0),
            materials=MaterialTable(
                np.ones((1, 4), np.float32),
                np.zeros(1, np.float32),
                np.ones(1, np.float32),
                np.zeros((1, 3), np.float32),
            ),
            lights=(regraft.Light("sun"),),
            world=(0.1, 0.2, 0.3),
        )
    )
    assert first_hit(scene).t[0] == 98.0
    mirror.apply(SceneDelta(hidden=handles(1)))
    assert first_hit(scene).t[0] == 99.0
    mirror.apply(SceneDelta(shown=handles(1), moved=handles(1), transforms=raised(5.0)))
    assert first_hit(scene).t[0] == 95.0
    mirror.apply(SceneDelta(deformed={1: TRIANGLE + np.array([0, 0, 1], np.float32)}))
    assert first_hit(scene).t[0] == 94.0
    square = MeshData(
        "square",
        np.array([[-1, -1, 3], [1, -1, 3], [1, 1, 3], [-1, 1, 3]], np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
    )
    mirror.apply(SceneDelta(retopologised={1: square}))
    assert first_hit(scene).t[0] == 92.0
    mirror.apply(SceneDelta(removed=handles(1), removed_meshes=[1]))
    assert first_hit(scene).t[0] == 99.0
    assert scene.counts()["meshes"] == 1
