"""A shot with everything in one mesh: what moves is then for the library to find."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from regraft.study.shot import Shot, ShotWriter

Points = npt.NDArray[np.float32]
Faces = npt.NDArray[np.uint32]


def flatten(shot: Shot, folder: Path) -> Shot:
    """`shot` with all visible instances as one mesh in world space, written into `folder`, which
    exists. Other triangles, or others of them seen, make it another mesh."""
    scene = _Placed()
    before: list[Any] | None = None
    with ShotWriter(folder) as writer:
        for position, frame in enumerate(shot.frames):
            shot.apply(position, scene)
            now = scene.topology()
            if before is None:
                writer.add_call("add_mesh", (scene.points(), scene.faces()), {})
                writer.add_call("add_instance", (0, np.eye(4)), {})
            elif now == before:
                writer.add_call("set_vertices", (0, scene.points()), {})
            else:
                writer.add_call("set_mesh", (0, scene.points(), scene.faces()), {})
            before = now
            writer.end_frame(frame, shot.camera(position))
    return Shot(folder)


class _Placed:
    """Stands in for a `regraft.Scene` and keeps where every vertex is."""

    def __init__(self) -> None:
        self._meshes: list[tuple[Points, Faces]] = []
        self._editions: list[int] = []
        self._instances: dict[int, tuple[int, npt.NDArray[np.float64]]] = {}
        self._hidden: set[int] = set()
        self._next_instance = 0

    def __getattr__(self, name: str) -> Any:
        return lambda *_args, **_more: None

    def topology(self) -> list[Any]:
        """Equal as long as the same triangles are seen."""
        return [(i, mesh, self._editions[mesh]) for i, mesh, _ in self._seen()]

    def points(self) -> Points:
        """(V, 3) of all that is seen, world frame."""
        points: Points = np.concatenate(
            [
                self._meshes[mesh][0] @ matrix[:3, :3].T + matrix[:3, 3]
                for _, mesh, matrix in self._seen()
            ]
        ).astype(np.float32)
        return points

    def faces(self) -> Faces:
        """(T, 3), corners in `points`."""
        first, faces = 0, []
        for _, mesh, _ in self._seen():
            points, corners = self._meshes[mesh]
            faces.append(corners + np.uint32(first))
            first += len(points)
        joined: Faces = np.concatenate(faces)
        return joined

    def _seen(self) -> list[tuple[int, int, npt.NDArray[np.float64]]]:
        return [(i, *placed) for i, placed in self._instances.items() if i not in self._hidden]

    def add_mesh(self, vertices: Points, triangles: Faces, **_: Any) -> None:
        self._meshes.append((np.array(vertices), np.array(triangles)))
        self._editions.append(0)

    def set_vertices(self, mesh: int, vertices: Points) -> None:
        self._meshes[mesh] = (np.array(vertices), self._meshes[mesh][1])

    def set_mesh(self, mesh: int, vertices: Points, triangles: Faces, **_: Any) -> None:
        self._meshes[mesh] = (np.array(vertices), np.array(triangles))
        self._editions[mesh] += 1

    def add_instance(self, mesh: int, transform: Any = None, **_: Any) -> None:
        matrix = np.eye(4) if transform is None else np.array(transform, np.float64)
        self._instances[self._next_instance] = (mesh, matrix)
        self._next_instance += 1

    def add_instances(self, meshes: Any, transforms: Any, **_: Any) -> None:
        for mesh, matrix in zip(meshes, transforms, strict=True):
            self.add_instance(int(mesh), matrix)

    def set_transform(self, instance: int, matrix: Any) -> None:
        self._instances[instance] = (self._instances[instance][0], np.array(matrix, np.float64))

    def set_transforms(self, ids: Any, transforms: Any) -> None:
        for instance, matrix in zip(ids, transforms, strict=True):
            self.set_transform(int(instance), matrix)

    def set_visible(self, instance: int, flag: bool) -> None:
        (self._hidden.discard if flag else self._hidden.add)(instance)

    def remove_instance(self, instance: int) -> None:
        del self._instances[instance]

    def remove_instances(self, ids: Any) -> None:
        for instance in ids:
            del self._instances[int(instance)]
