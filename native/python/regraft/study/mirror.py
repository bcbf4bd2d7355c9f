"""A scene that also keeps its geometry in Python, to ask what is true of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import regraft

Numbers = npt.NDArray[np.float64]


class Mirror:
    """Stands in for a `regraft.Scene`: what is done to it is done to the scene as well.

    Instances stand where they are put, seen through `place` (4,4): the scene's world is `place`
    times the mirror's. Motion is exaggerated `stretch` times, away from where things were first.
    """

    def __init__(self, scene: regraft.Scene, stretch: float = 1.0) -> None:
        self.scene, self.place = scene, np.eye(4)
        self._stretch, self._originals = stretch, 0
        self._meshes: dict[int, tuple[Numbers, npt.NDArray[np.uint32]]] = {}
        self._instances: dict[int, tuple[int, Numbers]] = {}
        self._first: dict[tuple[str, int], Numbers] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scene, name)

    def add_mesh(self, vertices: Any, triangles: Any, **more: Any) -> int:
        mesh = self.scene.add_mesh(vertices, triangles, **more)
        self._keep(mesh, vertices, triangles)
        return mesh

    def set_mesh(self, mesh: int, vertices: Any, triangles: Any, **more: Any) -> None:
        self.scene.set_mesh(mesh, vertices, triangles, **more)
        self._keep(mesh, vertices, triangles)

    def set_vertices(self, mesh: int, vertices: Any) -> None:
        first = self._first["mesh", mesh]
        moved = (first + self._stretch * (vertices - first)).astype(np.float32)
        self.scene.set_vertices(mesh, moved)
        self._meshes[mesh] = (moved.astype(np.float64), self._meshes[mesh][1])

    def add_instance(self, mesh: int, transform: Any = None, **more: Any) -> int:
        matrix = np.eye(4) if transform is None else transform
        instance = self.scene.add_instance(mesh, self.place @ matrix, **more)
        self._put(instance, mesh, matrix)
        return instance

    def add_instances(self, meshes: Any, transforms: Any, **more: Any) -> Any:
        ids = self.scene.add_instances(meshes, self.place @ transforms, **more)
        for instance, mesh, matrix in zip(ids.tolist(), meshes, transforms, strict=True):
            self._put(instance, int(mesh), matrix)
        return ids

    def set_transform(self, instance: int, matrix: Any) -> None:
        self.set_transforms([instance], np.asarray(matrix)[None])

    def set_transforms(self, ids: Any, matrices: Any) -> None:
        for instance, matrix in zip(map(int, ids), matrices, strict=True):
            first = self._first["instance", instance]
            mesh, _ = self._instances[instance]
            self._instances[instance] = (mesh, first + self._stretch * (matrix - first))
        moved = np.stack([self._instances[int(i)][1] for i in ids])
        self.scene.set_transforms(ids, self.place @ moved)

    def remove_instance(self, instance: int) -> None:
        self.remove_instances(np.array([instance], np.uint32))

    def remove_instances(self, ids: Any) -> None:
        self.scene.remove_instances(ids)
        for instance in map(int, ids):
            del self._instances[instance]

    def add_copy(self, m: Numbers) -> None:
        """A second instance of every instance there is but the copies, moved by `m`."""
        originals = [(mesh, matrix) for mesh, matrix in self._instances.values()]
        originals = originals[: self._originals or len(originals)]
        self._originals = len(originals)
        meshes = np.array([mesh for mesh, _ in originals], np.uint32)
        self.add_instances(meshes, np.stack([m @ matrix for _, matrix in originals]))

    def see_through(self, place: Numbers) -> None:
        """Moves everything there is."""
        self.place = place
        ids = np.array(list(self._instances), np.uint32)
        if len(ids):
            matrices = np.stack([matrix for _, matrix in self._instances.values()])
            self.scene.set_transforms(ids, place @ matrices)

    def corners(self, instance_ids: Any, prim_ids: Any) -> Numbers:
        """(N, 3, 3) corners of triangles in the mirror's world."""
        out = np.empty((len(prim_ids), 3, 3))
        for instance in np.unique(instance_ids).tolist():
            chosen = instance_ids == instance
            mesh, matrix = self._instances[instance]
            vertices, triangles = self._meshes[mesh]
            local = vertices[triangles[prim_ids[chosen]]]
            out[chosen] = local @ matrix[:3, :3].T + matrix[:3, 3]
        return out

    def _keep(self, mesh: int, vertices: Any, triangles: Any) -> None:
        self._meshes[mesh] = (np.array(vertices, np.float64), np.array(triangles))
        self._first["mesh", mesh] = self._meshes[mesh][0]

    def _put(self, instance: int, mesh: int, matrix: Any) -> None:
        self._first["instance", instance] = np.array(matrix, np.float64)
        self._instances[instance] = (mesh, self._first["instance", instance])
