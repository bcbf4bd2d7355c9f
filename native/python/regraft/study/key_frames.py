"""Key frames of a recorded shot, for the policy that plans for all of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from regraft import Scene
from regraft.study.shot import Shot

# As many as the library looks at.
MOST = 8
# Why there is no planning for a mesh.
CHANGES = (
    'gets other triangles during the shot: policy "shot" builds every tree once, for all of it, '
    "and cannot plan for that; use another policy"
)
Array = npt.NDArray[Any]


def spread(frames: Sequence[int], count: int = MOST) -> list[int]:
    """`count` of the frames, evenly, the first and the last among them."""
    chosen = np.linspace(0, len(frames) - 1, min(count, len(frames)))
    return [frames[round(i)] for i in chosen]


def remade(shot: Shot) -> str | None:
    """The name of a mesh whose triangles change during the shot, if there is one."""
    names: list[str] = []
    for position in range(len(shot)):
        for call, args, kwargs in shot.edits(position):
            if call == "add_mesh":
                names.append(kwargs.get("name") or f"mesh {len(names)}")
            elif call == "set_mesh":
                return names[args[0]]
    return None


def give(shot: Shot, scene: Scene, position: int, count: int = MOST) -> tuple[set[int], set[int]]:
    """Tells `scene`, brought to the frame at `position` and not updated yet, where what has just
    been added to it will be in `count` frames spread evenly over the shot. A mesh whose triangles
    change has none, nor has what stays where it is. Returns the meshes and the instances that now
    have some."""
    if not any(name.startswith("add_") for name, _, _ in shot.edits(position)):
        return set(), set()
    wanted = set(spread(range(len(shot)), count))
    places = _Places()
    vertices: dict[int, list[Array]] = {}
    transforms: dict[int, list[Array]] = {}
    known: list[tuple[int, int]] = [(0, 0)]
    for at in range(len(shot)):
        shot.apply(at, places)
        known.append((len(places.vertices), len(places.transforms)))
        if at in wanted or at == position:
            for here, keys in ((places.vertices, vertices), (places.transforms, transforms)):
                for number, array in here.items():
                    keys.setdefault(number, []).append(array)
    (first_mesh, first_instance), (end_mesh, end_instance) = known[position : position + 2]
    meshes = (places.moved_meshes - places.remade_meshes) & set(range(first_mesh, end_mesh))
    for mesh in meshes:
        scene.set_key_vertices(mesh, np.stack(vertices[mesh][:count]))
    instances = places.moved_instances & set(range(first_instance, end_instance))
    for instance in instances:
        scene.set_key_transforms(instance, np.stack(transforms[instance][:count]))
    return meshes, instances


class _Places:
    """Stands in for a scene and keeps where everything is; ids are handed out in order."""

    def __init__(self) -> None:
        self.vertices: dict[int, Array] = {}
        self.transforms: dict[int, Array] = {}
        self.moved_meshes: set[int] = set()
        self.remade_meshes: set[int] = set()
        self.moved_instances: set[int] = set()

    def __getattr__(self, _name: str) -> Any:
        return lambda *_args, **_kwargs: None

    def add_mesh(self, vertices: Array, *_args: Any, **_kwargs: Any) -> None:
        self.vertices[len(self.vertices)] = vertices

    def set_vertices(self, mesh: int, vertices: Array) -> None:
        self.vertices[mesh] = vertices
        self.moved_meshes.add(mesh)

    def set_mesh(self, mesh: int, vertices: Array, *_args: Any, **_kwargs: Any) -> None:
        self.vertices[mesh] = vertices
        self.remade_meshes.add(mesh)

    def add_instance(self, _mesh: int, transform: Array | None = None, **_kwargs: Any) -> None:
        self.transforms[len(self.transforms)] = np.eye(4) if transform is None else transform

    def add_instances(self, _meshes: Array, transforms: Array, **_kwargs: Any) -> None:
        for transform in transforms:
            self.transforms[len(self.transforms)] = transform

    def set_transform(self, instance: int, transform: Array) -> None:
        self.transforms[instance] = transform
        self.moved_instances.add(instance)

    def set_transforms(self, instances: Array, transforms: Array) -> None:
        for instance, transform in zip(instances, transforms, strict=True):
            self.transforms[int(instance)] = transform
            self.moved_instances.add(int(instance))
