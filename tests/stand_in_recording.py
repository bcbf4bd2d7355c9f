"""Recording without Blender: frames of a landscape in which a little moves."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from regraft.cli.job import RenderJob, SceneInfo
from regraft.study import local_motion
from regraft.study.shot import Shot, ShotWriter
from stand_in_backend import StandInBackend

TRIANGLES, MOVING = 2_000, 400


class RecordingStandIn(StandInBackend):
    """`at_frame` is called before each frame is recorded; in frame `remade` a mesh gets other
    triangles. `planned`: the key frames that were planned by."""

    def __init__(
        self, frames: int = 3, at_frame: Callable[[int], None] = lambda _: None, remade: int = 0
    ) -> None:
        super().__init__(frames=tuple(range(1, frames + 1)))
        self._at_frame, self._remade = at_frame, remade
        self.planned: tuple[int, ...] = ()

    def open(self, job: RenderJob) -> SceneInfo:
        self.job = job
        return super().open(job)

    def begin_recording(self, folder: Path) -> None:
        self._source = tempfile.TemporaryDirectory()
        self._shot = local_motion.make(Path(self._source.name), TRIANGLES, MOVING, len(self.frames))
        self._writer, self._unsaid = ShotWriter(folder), 0

    def record_frame(self, frame: int) -> None:
        self._at_frame(frame)
        while self._unsaid < frame:
            for call in self._shot.edits(self._unsaid):
                self._writer.add_call(*call)
            self._unsaid += 1
        if frame == self._remade:
            self._writer.add_call("set_mesh", (0, np.zeros((3, 3)), np.arange(3)), {})
        self._writer.end_frame(frame, self._shot.camera(frame - 1))

    def end_recording(self, is_complete: bool) -> None:
        self._writer.close(is_complete=is_complete)
        self._source.cleanup()

    def plan(self, folder: Path) -> None:
        self.planned = Shot(folder).frames


def shot_in(folder: Path, frames: int = 3) -> Shot:
    """The shot that the stand-in records."""
    return local_motion.make(folder, TRIANGLES, MOVING, frames)
