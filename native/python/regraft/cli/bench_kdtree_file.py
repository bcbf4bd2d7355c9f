"""A scene of a file, written down for the program that measures k-d trees."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

import regraft
from regraft.study.shot import Shot

NONE = 0xFFFFFFFF
Numbers = npt.NDArray[np.float64]


class Layout:
    """Stands in for a `regraft.Scene` while a frame's edits are replayed, and keeps what it is told
    of groups, meshes and instances."""

    def __init__(self) -> None:
        self.parents: list[int] = []
        self.meshes: list[tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]] = []
        self.instances: list[tuple[int, int, Numbers]] = []

    def __getattr__(self, name: str) -> Any:
        return lambda *_args, **_more: None

    def add_group(self, parent: int | None = None, **_: Any) -> None:
        self.parents.append(NONE if parent is None else parent)

    def add_mesh(self, vertices: Any, triangles: Any, **_: Any) -> None:
        self.meshes.append((np.asarray(vertices, np.float32), np.asarray(triangles, np.uint32)))

    def add_instance(
        self, mesh: int, transform: Any = None, *, group: int | None = None, **_: Any
    ) -> None:
        matrix = np.eye(4) if transform is None else np.asarray(transform, np.float64)
        self.instances.append((mesh, NONE if group is None else group, matrix))

    def add_instances(self, meshes: Any, transforms: Any, *, groups: Any = None, **_: Any) -> None:
        every = np.full(len(meshes), NONE, np.uint32) if groups is None else groups
        for mesh, group, matrix in zip(meshes, every, transforms, strict=True):
            self.add_instance(int(mesh), matrix, group=int(group))


def write(shot: Shot, path: Path) -> None:
    """The shot's first frame as `native/bench/kdtree_file.h` reads it."""
    layout = Layout()
    shot.apply(0, layout)
    eye, target = _look(shot)
    with path.open("wb") as out:
        _put(out, np.uint32, len(layout.parents), *layout.parents, len(layout.meshes))
        for vertices, triangles in layout.meshes:
            _put(out, np.uint32, len(vertices), len(triangles))
            _put(out, np.float32, vertices)
            _put(out, np.uint32, triangles)
        _put(out, np.uint32, len(layout.instances))
        for mesh, group, matrix in layout.instances:
            _put(out, np.uint32, mesh, group)
            _put(out, np.float64, matrix.T)
        _put(out, np.float64, eye, target)


def _put(out: BinaryIO, kind: type[np.generic], *values: Any) -> None:
    for value in values:
        out.write(np.asarray(value, kind).tobytes())


def _look(shot: Shot) -> tuple[Numbers, Numbers]:
    """Where the camera stands, and what is in the middle of its picture."""
    scene = regraft.Scene()
    shot.apply(0, scene)
    scene.update()
    matrix = np.asarray(shot.camera(0).matrix)
    eye, ahead = matrix[:3, 3], -matrix[:3, 2]
    t = scene.closest_hit(eye[None], ahead[None]).t[0]
    away = t if np.isfinite(t) else np.linalg.norm(scene.bounds().mean(axis=0) - eye)
    return eye, eye + float(away) * ahead
