"""Simulations need their frames in order. Runs inside Blender."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


class RunUp:
    """Steps a scene whose simulations are not baked through every frame, rendered or not.

    Otherwise a resumed or partial render would show a simulation that never ran. The scene's own
    evaluation runs the simulation and fills the caches that the render then reads; stepping only
    the skipped frames gave other positions than a render of all frames.
    """

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self.needed = has_unbaked_simulation(scene)
        self._next = int(scene.frame_start)

    def to(self, frame: int) -> None:
        """Brings the simulation to `frame`."""
        if self.needed:
            for step in range(self._next, frame + 1):
                self._scene.frame_set(step)
        self._next = max(self._next, frame + 1)


def has_unbaked_simulation(scene: Any) -> bool:
    """Whether the look of a frame depends on the frames before having been evaluated."""
    if any(not cache.is_baked for cache in _point_caches(scene)):
        return True
    return any(_has_simulation_zone(o) for o in scene.objects)


def _point_caches(scene: Any) -> Iterator[Any]:
    world = scene.rigidbody_world
    if world is not None and world.enabled and world.collection and world.collection.objects:
        yield world.point_cache
    for item in scene.objects:
        yield from (m.point_cache for m in item.modifiers if hasattr(m, "point_cache"))
        yield from (p.point_cache for p in item.particle_systems)


def _has_simulation_zone(item: Any) -> bool:
    trees = [m.node_group for m in item.modifiers if m.type == "NODES" and m.node_group]
    seen: set[str] = set()
    while trees:
        tree = trees.pop()
        if tree.name in seen:
            continue
        seen.add(tree.name)
        for node in tree.nodes:
            if node.bl_idname == "GeometryNodeSimulationOutput":
                return True
            if getattr(node, "node_tree", None):
                trees.append(node.node_tree)
    return False
