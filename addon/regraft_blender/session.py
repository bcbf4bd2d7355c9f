"""Native scenes that outlive frames and engine instances, and what the last frames cost.

The `regraft` command relies on this surface, so change it only together with the command:

- `add_frame_listener(function)`, `remove_frame_listener(function)`: `function` is called with the
  FrameStatistics of every finished frame (attributes, and `as_dict()`; see docs/statistics.md).
- `last_statistics() -> dict | None`: of the last finished frame.
- `new_scene(threads)` makes the native scene of each session; replace it to see what is done to it.
- `Scene.regraft` has `shading samples policy structure layout threads`, with the names of the
  NumPy API as values; `ViewLayer.regraft` has `use_pass_cost`. `register()` and `unregister()` of
  the package may be called in any process that has bpy.
"""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from . import compat
from .sync.delta import SceneDelta, SceneMirror
from .sync.depsgraph_reader import DepsgraphReader

log = logging.getLogger(__name__)

FINAL = "final"
# Frames whose statistics are kept for "Save statistics".
HISTORY_LENGTH = 100_000

Key = tuple[object, ...]
Listener = Callable[[Any], None]


@dataclass(frozen=True)
class Options:
    """What Scene.regraft asks of the library; names and values as in the NumPy API."""

    shading: str
    samples: int
    policy: str
    structure: str
    layout: str
    threads: int
    headlight: bool

    @staticmethod
    def of(scene: bpy.types.Scene) -> Options:
        """The settings of a scene; without a number of threads of its own, Blender's counts."""
        settings, render = scene.regraft, scene.render
        threads = settings.threads or (render.threads if render.threads_mode == "FIXED" else 0)
        return Options(
            shading=settings.shading,
            samples=settings.samples,
            policy=settings.policy,
            structure=settings.structure,
            layout=settings.layout,
            threads=threads,
            headlight=settings.use_headlight,
        )


def new_scene(threads: int) -> Any:
    """An empty native scene."""
    return compat.native().Scene(threads=threads)


@dataclass(frozen=True)
class Nodes:
    """Nodes of the trees `depth` levels below the root after one update: boxes (N, 2, 3) in the
    world, damage (N,); and the boxes (M, 2, 3) of those that this update made anew."""

    depth: int
    boxes: npt.NDArray[np.float64]
    damage: npt.NDArray[np.float64]
    rebuilt: npt.NDArray[np.float64]


class Session:
    """One native scene, and what is needed to keep it like Blender's."""

    def __init__(self, threads: int) -> None:
        self.threads = threads
        self.scene = new_scene(threads)
        self.is_open = True
        # Set by a viewport: stops whatever still traces the scene in another thread.
        self.stop_tracing: Callable[[], None] = lambda: None
        self._nodes: Nodes | None = None
        self._reader = DepsgraphReader()
        self._mirror = SceneMirror(self.scene)

    def synchronise(
        self,
        depsgraph: bpy.types.Depsgraph,
        options: Options,
        *,
        view: bpy.types.SpaceView3D | None = None,
        everything: bool = False,
    ) -> tuple[SceneDelta, float]:
        """Read what changed into the native scene; the delta, and the milliseconds it took.

        A session that failed half way is closed, because nobody knows what it still holds.
        """
        began = time.perf_counter()
        self._reader.headlight = options.headlight
        try:
            delta = self._reader.read(depsgraph, view=view, everything=everything)
            if not delta.is_empty():
                self.stop_tracing()
                self._nodes = None
                self._mirror.apply(delta)
        except Exception:
            close(self)
            raise
        return delta, (time.perf_counter() - began) * 1e3

    def update(self, options: Options, frames_left: int | None = None, camera: Any = None) -> Any:
        """Bring the trees up to date; UpdateStatistics."""
        return self.scene.update(
            policy=options.policy,
            structure=options.structure,
            layout=options.layout,
            frames_left=frames_left,
            camera=camera,
        )

    def nodes_at(self, depth: int) -> Nodes | None:
        """The trees' nodes after the last update; None while the scene waits for the next one."""
        if self._nodes is None or self._nodes.depth != depth:
            try:
                batch, rebuilt = self.scene.damaged_nodes(depth), self.scene.rebuilt_nodes()
            except RuntimeError:
                return None
            self._nodes = Nodes(depth, batch.boxes, batch.damage, rebuilt.boxes)
        return self._nodes


_sessions: dict[Key, Session] = {}
_listeners: list[Listener] = []
_history: deque[dict[str, Any]] = deque(maxlen=HISTORY_LENGTH)


def session_for(
    depsgraph: bpy.types.Depsgraph, options: Options, purpose: object = FINAL
) -> Session:
    """The session of this scene, view layer and purpose (FINAL or a viewport's address); made
    when there is none yet or the number of threads changed."""
    scene = depsgraph.scene.original
    key = (scene.name_full, depsgraph.view_layer.name, purpose)
    session = _sessions.get(key)
    if session is not None and session.threads != options.threads:
        close(session)
        session = None
    if session is None:
        session = _sessions[key] = Session(options.threads)
    return session


def seen_by(
    scene: bpy.types.Scene, layer: bpy.types.ViewLayer, space: bpy.types.SpaceView3D
) -> Session | None:
    """The session that a viewport shows, or else that of the last final frame."""
    for purpose in (space.as_pointer(), FINAL):
        session = _sessions.get((scene.name_full, layer.name, purpose))
        if session is not None:
            return session
    return None


def close(session: Session) -> None:
    """Let go of one session's native scene."""
    session.stop_tracing()
    session.is_open = False
    for key in [key for key, value in _sessions.items() if value is session]:
        del _sessions[key]


def close_all() -> None:
    """Let go of all native scenes: after undo and file load nothing of them holds."""
    for session in list(_sessions.values()):
        close(session)


def add_frame_listener(listener: Listener) -> None:
    """Call `listener(statistics)` after every frame."""
    _listeners.append(listener)


def remove_frame_listener(listener: Listener) -> None:
    """Stop calling `listener`; one that is not there is no error."""
    if listener in _listeners:
        _listeners.remove(listener)


def publish(statistics: Any) -> None:
    """Remember a finished frame's statistics and tell the listeners, whatever they do."""
    _history.append(dict(statistics.as_dict()))
    for listener in list(_listeners):
        try:
            listener(statistics)
        except Exception:
            log.exception("a frame listener failed")


def last_statistics() -> dict[str, Any] | None:
    """Statistics of the last finished frame."""
    return _history[-1] if _history else None


def history() -> list[dict[str, Any]]:
    """Statistics of the frames since the history was cleared, oldest first."""
    return list(_history)


def clear_history() -> None:
    """Forget the statistics, as when an animation begins."""
    _history.clear()
