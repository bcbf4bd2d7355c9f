"""Drives one of Blender's render engines, frame by frame. Runs inside Blender."""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partialmethod
from typing import Any

from regraft.cli.errors import InputError
from regraft.cli.job import RenderJob
from regraft.study.planned_scene import PlannedScene
from regraft.study.shot import Recorder, Shot, ShotWriter

ADDON = "regraft_blender"
# Longer reports hold arguments and stacks that nobody reads in one line.
_LONGEST = 300


class Engine:
    """The engine `name`; for REGRAFT the add-on is registered for as long as this lives."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._addon = _Addon() if name == "REGRAFT" else None
        self._clock = _EvaluationClock()

    def set_up(self, scene: Any, layer: Any, job: RenderJob) -> None:
        """Makes the scene render with this engine and the settings of the job."""
        scene.render.engine = self.name
        scene.render.use_persistent_data = True
        if job.threads:
            scene.render.threads_mode, scene.render.threads = "FIXED", job.threads
        if self._addon:
            self._addon.set_up(scene, layer, job)
        elif self.name == "CYCLES":
            scene.cycles.samples, scene.cycles.use_denoising = job.samples, False
            scene.cycles.use_adaptive_sampling = False
        else:
            scene.display.render_aa = "OFF"

    def begin_frame(self, scene: Any) -> None:
        """From here on the evaluation of `scene` counts as the next frame's."""
        self._clock.start(scene)

    def render(self, scene: Any, frame: int) -> dict[str, Any]:
        """Renders into Blender's Render Result; returns the statistics of the frame.

        Raises InputError with the engine's own words if it failed.
        """
        import bpy

        # The operator takes its frame from the window's scene, whichever scene it renders.
        bpy.context.scene.frame_current = scene.frame_current = frame
        try:
            bpy.ops.render.render(scene=scene.name)
        except RuntimeError as error:
            raise InputError(f"frame {frame}: {report_words(error)}") from error
        row = self._addon.take_statistics(frame) if self._addon else {}
        row["evaluate_ms"] = self._clock.evaluate_ms
        return row

    @contextmanager
    def watched(self, writer: ShotWriter) -> Iterator[Recorder]:
        """While this lives, what the add-on does to its native scene is written down."""
        assert self._addon
        with self._addon.watched(writer) as recorder:
            yield recorder

    def plan(self, shot: Shot) -> None:
        """From here on native scenes begin anew, planned by the key frames in `shot`."""
        assert self._addon
        self._addon.plan(shot)

    def read_everything(self) -> None:
        """From here on what has not changed is read as well: for benchmarks."""
        assert self._addon
        self._addon.read_everything()

    def close(self) -> None:
        """Takes handlers and add-on out of Blender."""
        self._clock.close()
        if self._addon:
            self._addon.close()


class _Addon:
    """The add-on package, registered in this process only."""

    def __init__(self) -> None:
        try:
            self._package = importlib.import_module(ADDON)
            self._session: Any = importlib.import_module(f"{ADDON}.session")
        except ImportError as error:
            raise InputError(f"the add-on {ADDON} cannot be loaded: {error}") from error
        self._package.register()
        self._new_scene = self._session.new_scene
        self._rows: list[dict[str, Any]] = []
        self._session.add_frame_listener(self._on_frame)

    def set_up(self, scene: Any, layer: Any, job: RenderJob) -> None:
        settings = scene.regraft
        for name in ("shading", "samples", "structure", "layout", "threads"):
            setattr(settings, name, getattr(job, name))
        # Key frames are recorded by a policy that needs none; `plan` sees to the rest.
        settings.policy = "refit" if job.policy == "shot" else job.policy
        layer.regraft.use_pass_cost = "cost" in job.passes

    def take_statistics(self, frame: int) -> dict[str, Any]:
        if not self._rows:
            raise InputError(f"frame {frame}: the engine drew nothing and did not say why")
        row = self._rows[-1]
        self._rows.clear()
        return row

    @contextmanager
    def watched(self, writer: ShotWriter) -> Iterator[Recorder]:
        new_scene = self._session.new_scene
        recorder = Recorder(new_scene(0), writer)
        self._session.new_scene = lambda _threads: recorder
        try:
            yield recorder
        finally:
            self._session.new_scene = new_scene

    def plan(self, shot: Shot) -> None:
        self._session.close_all()
        self._session.new_scene = lambda threads: PlannedScene(self._new_scene(threads), shot)

    def read_everything(self) -> None:
        session = self._session.Session
        session.synchronise = partialmethod(session.synchronise, everything=True)

    def close(self) -> None:
        self._session.remove_frame_listener(self._on_frame)
        self._session.new_scene = self._new_scene
        self._package.unregister()

    def _on_frame(self, statistics: Any) -> None:
        self._rows.append(dict(statistics.as_dict()))


class _EvaluationClock:
    """Milliseconds Blender spends evaluating the rendered scene, from its frame handlers."""

    def __init__(self) -> None:
        import bpy

        self.evaluate_ms = 0.0
        self._name, self._began = "", 0.0
        self._lists = (bpy.app.handlers.frame_change_pre, bpy.app.handlers.frame_change_post)
        self._handlers = (self._before, self._after)
        for handlers, handler in zip(self._lists, self._handlers, strict=True):
            handlers.append(handler)

    def start(self, scene: Any) -> None:
        self._name, self.evaluate_ms = scene.name, 0.0

    def close(self) -> None:
        for handlers, handler in zip(self._lists, self._handlers, strict=True):
            if handler in handlers:
                handlers.remove(handler)

    def _before(self, scene: Any, _depsgraph: Any) -> None:
        if scene.name == self._name:
            self._began = time.perf_counter()

    def _after(self, scene: Any, _depsgraph: Any) -> None:
        if scene.name == self._name:
            self.evaluate_ms += (time.perf_counter() - self._began) * 1e3


def report_words(error: RuntimeError) -> str:
    """Blender's report in one line: its first message, and of a traceback only the last words."""
    text = str(error).removeprefix("Error: ").strip()
    if "Traceback (most recent call last)" in text:
        said = [line for line in text.splitlines() if line[:1].isalpha() and ": " in line]
        said = [line for line in said if not line.startswith(("Location:", "Python:"))]
        text = said[-1] if said else text
    words = " ".join(text.split("\nError: ")[0].split())
    return words if len(words) <= _LONGEST else f"{words[:_LONGEST]}… (--verbose shows all)"
