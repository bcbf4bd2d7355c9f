"""A shot, written down for the program that plays it to Embree too."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from regraft import Camera
from regraft.cli.errors import InputError
from regraft.study.shot import Shot

END, MESH, VERTICES, TRIANGLES, NO_MESH, INSTANCE, TRANSFORM, VISIBLE, NO_INSTANCE = range(9)


def write(shot: Shot, path: Path) -> None:
    """All frames as `native/bench/shot_file.h` reads them.

    Raises InputError unless every camera is a perspective.
    """
    with path.open("wb") as out:
        _put(out, np.uint32, len(shot))
        writer = _Writer(out)
        for position, frame in enumerate(shot.frames):
            shot.apply(position, writer)
            _put(out, np.uint32, END, frame)
            _put_camera(out, shot.camera(position))


class _Writer:
    """Stands in for a `regraft.Scene` and writes down its edits of geometry."""

    def __init__(self, out: BinaryIO) -> None:
        self._out = out

    def __getattr__(self, name: str) -> Any:
        return lambda *_args, **_more: None

    def add_mesh(self, vertices: Any, triangles: Any, **_: Any) -> None:
        self._edit(MESH)
        self._geometry(vertices, triangles)

    def set_vertices(self, mesh: int, vertices: Any) -> None:
        self._edit(VERTICES, mesh, len(vertices))
        _put(self._out, np.float32, vertices)

    def set_mesh(self, mesh: int, vertices: Any, triangles: Any, **_: Any) -> None:
        self._edit(TRIANGLES, mesh)
        self._geometry(vertices, triangles)

    def remove_mesh(self, mesh: int) -> None:
        self._edit(NO_MESH, mesh)

    def add_instance(self, mesh: int, transform: Any = None, **_: Any) -> None:
        self._edit(INSTANCE, mesh)
        self._matrix(np.eye(4) if transform is None else transform)

    def add_instances(self, meshes: Any, transforms: Any, **_: Any) -> None:
        for mesh, matrix in zip(meshes, transforms, strict=True):
            self.add_instance(mesh, matrix)

    def set_transform(self, instance: int, matrix: Any) -> None:
        self._edit(TRANSFORM, instance)
        self._matrix(matrix)

    def set_transforms(self, ids: Any, transforms: Any) -> None:
        for instance, matrix in zip(ids, transforms, strict=True):
            self.set_transform(instance, matrix)

    def set_visible(self, instance: int, flag: bool) -> None:
        self._edit(VISIBLE, instance, int(flag))

    def remove_instance(self, instance: int) -> None:
        self._edit(NO_INSTANCE, instance)

    def remove_instances(self, ids: Any) -> None:
        for instance in ids:
            self.remove_instance(instance)

    def _edit(self, *numbers: int) -> None:
        _put(self._out, np.uint32, *numbers)

    def _geometry(self, vertices: Any, triangles: Any) -> None:
        self._edit(len(vertices), len(triangles))
        _put(self._out, np.float32, vertices)
        _put(self._out, np.uint32, triangles)

    def _matrix(self, matrix: Any) -> None:
        _put(self._out, np.float64, np.asarray(matrix).T)


def _put(out: BinaryIO, kind: type[np.generic], *values: Any) -> None:
    for value in values:
        out.write(np.asarray(value, kind).tobytes())


def _put_camera(out: BinaryIO, camera: Camera) -> None:
    """The eye, and the picture's corner and edges seen from it."""
    if camera.kind != "perspective":
        raise InputError(f"its camera is {camera.kind}: peers are given perspectives only")
    left, right, bottom, top = camera.window
    turn = camera.matrix[:3, :3]
    corner = turn @ np.array([left, bottom, -1.0])
    _put(out, np.float64, camera.matrix[:3, 3], corner)
    _put(out, np.float64, turn[:, 0] * (right - left), turn[:, 1] * (top - bottom))
