"""Blender in this very process, as the Python module bpy."""

from __future__ import annotations

import atexit
from pathlib import Path
from typing import Any

from regraft.cli.blender_worker import BlenderWorker
from regraft.cli.job import RenderJob, SceneInfo
from regraft.formats.quiet import hold_back_output, silence_outputs


class InProcessBackend:
    """Calls the worker directly and holds back what Blender prints on its own."""

    place = "bpy, in this process"

    def __init__(self, verbose: bool) -> None:
        self._worker = BlenderWorker()
        if not verbose:
            atexit.register(silence_outputs)  # bpy reports its memory when the process ends
        self._verbose = verbose

    def probe(self) -> dict[str, Any]:
        """See BlenderWorker.probe."""
        with hold_back_output(self._verbose):
            return self._worker.probe()

    def open(self, job: RenderJob) -> SceneInfo:
        """See BlenderWorker.open."""
        with hold_back_output(self._verbose):
            return self._worker.open(job)

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        """See BlenderWorker.render."""
        with hold_back_output(self._verbose):
            return self._worker.render(frame, path)

    def begin_recording(self, folder: Path) -> None:
        """See BlenderWorker.begin_recording."""
        self._worker.begin_recording(folder)

    def record_frame(self, frame: int) -> None:
        """See BlenderWorker.record_frame."""
        with hold_back_output(self._verbose):
            self._worker.record_frame(frame)

    def end_recording(self, is_complete: bool) -> None:
        """See BlenderWorker.end_recording."""
        self._worker.end_recording(is_complete)

    def plan(self, folder: Path) -> None:
        """See BlenderWorker.plan."""
        self._worker.plan(folder)

    def close(self) -> None:
        """See BlenderWorker.close."""
        with hold_back_output(self._verbose):
            self._worker.close()
