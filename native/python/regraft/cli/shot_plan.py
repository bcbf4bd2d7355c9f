"""Key frames for `regraft render --policy shot`, which plans for all that is to be rendered."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from regraft.cli.backend import RecordingBackend
from regraft.cli.console import Console
from regraft.cli.errors import InputError, OutputError
from regraft.cli.interrupt import Interrupt
from regraft.cli.job import RenderJob
from regraft.cli.recording import record_frames
from regraft.study import key_frames
from regraft.study.shot import Shot


@contextmanager
def planned(
    job: RenderJob,
    backend: RecordingBackend,
    frames: Sequence[int],
    console: Console,
    interrupt: Interrupt,
) -> Iterator[None]:
    """While the block runs `backend`, which has `job` open and has rendered nothing, knows where
    things are in key frames spread over `frames`, if the job's policy asks for them.

    Raises InputError for a shot that cannot be planned, the errors of a render,
    InterruptedRunError.
    """
    if job.policy != "shot" or not frames:
        yield
        return
    try:
        folder = tempfile.TemporaryDirectory(prefix="regraft-keys-")
    except OSError as error:
        raise OutputError(f"no place for the key frames: {error}") from error
    with folder as name:
        keys = key_frames.spread(frames)
        interrupt.temporary = Path(name)
        with console.progress(len(keys), "key frames") as progress:
            record_frames(
                backend,
                keys,
                Path(name),
                interrupt,
                lambda frame: progress.step(f"key frame {frame} evaluated", f"frame {frame}"),
            )
        interrupt.temporary = None
        if mesh := key_frames.remade(Shot(Path(name))):
            raise InputError(f"{job.source}: {mesh} {key_frames.CHANGES}")
        backend.plan(Path(name))
        yield
