"""A scene whose trees are planned for a whole shot, by key frames that were recorded before."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import regraft
from regraft.study import key_frames
from regraft.study.shot import Shot

Array = npt.NDArray[Any]


class PlannedScene:
    """Stands in for a `regraft.Scene` and updates it by policy "shot", whatever is asked for.

    `shot` holds the key frames; before its first update the scene is given the same edits as in the
    first of them. What does not move in any of them, or is added later, is planned for as it is
    when it first moves.
    """

    def __init__(self, scene: Any, shot: Shot) -> None:
        self._scene, self._shot = scene, shot
        self._planned: tuple[set[int], set[int]] | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)

    def update(self, **options: Any) -> regraft.UpdateStatistics:
        """See `regraft.Scene.update`."""
        if self._planned is None:
            self._planned = key_frames.give(self._shot, self._scene, 0)
        done: regraft.UpdateStatistics = self._scene.update(**{**options, "policy": "shot"})
        return done

    def set_vertices(self, mesh: int, vertices: Array) -> None:
        """See `regraft.Scene.set_vertices`."""
        if self._is_new(0, mesh):
            self._scene.set_key_vertices(mesh, np.asarray(vertices)[None])
        self._scene.set_vertices(mesh, vertices)

    def set_mesh(self, mesh: int, *args: Any, **kwargs: Any) -> None:
        """Raises ValueError: there is no planning for triangles that come and go."""
        raise ValueError(f"mesh {mesh} {key_frames.CHANGES}")

    def set_transform(self, instance: int, transform: Array) -> None:
        """See `regraft.Scene.set_transform`."""
        self.set_transforms(np.array([instance], np.uint32), np.asarray(transform)[None])

    def set_transforms(self, instances: Array, transforms: Array) -> None:
        """See `regraft.Scene.set_transforms`."""
        for instance, transform in zip(instances, transforms, strict=True):
            if self._is_new(1, int(instance)):
                self._scene.set_key_transforms(int(instance), transform[None])
        self._scene.set_transforms(instances, transforms)

    def _is_new(self, kind: int, number: int) -> bool:
        if self._planned is None or number in self._planned[kind]:
            return False
        self._planned[kind].add(number)
        return True
