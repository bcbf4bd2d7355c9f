"""Makes a shot of a file, through Blender."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from regraft.cli.backend import RecordingBackend, choose_backend
from regraft.cli.console import Console
from regraft.cli.errors import InputError, OutputError
from regraft.cli.interrupt import Interrupt
from regraft.cli.job import RenderJob
from regraft.study.shot import Shot

# What is drawn meanwhile is thrown away; its shape is that of the pictures the shot is traced in.
SIZE = (64, 64)


@dataclass(frozen=True)
class Recording:
    """What to record: a file's frames (all if None, or the first) as a mode of shading needs
    them."""

    source: Path
    frames: Sequence[int] | None = None
    shading: str = "clay"
    verbose: bool = False
    only_first: bool = False


@contextmanager
def recorded(wanted: Recording, console: Console, interrupt: Interrupt) -> Iterator[Shot]:
    """The shot, in a folder that lives as long as the block.

    Raises the errors of a render, InputError for frames that the file does not have,
    InterruptedRunError.
    """
    console.note(f"recording {wanted.source}")
    try:
        folder = tempfile.TemporaryDirectory(prefix="regraft-shot-")
    except OSError as error:
        raise OutputError(f"no place for the shot: {error}") from error
    with folder as name:
        interrupt.temporary = Path(name)
        try:
            yield _record(wanted, Path(name), console, interrupt)
        finally:
            interrupt.temporary = None


def _record(wanted: Recording, folder: Path, console: Console, interrupt: Interrupt) -> Shot:
    backend = choose_backend(wanted.verbose)
    try:
        job = RenderJob(str(wanted.source.resolve()), *SIZE, shading=wanted.shading, policy="refit")
        info = backend.open(job)
        for note in info.notes:
            console.note(note)
        frames = [f for f in info.frames if wanted.frames is None or f in wanted.frames]
        if wanted.only_first:
            frames = frames[:1]
        if not frames:
            raise InputError(f"{wanted.source} has none of the frames asked for")
        record_frames(backend, frames, folder, interrupt)
    finally:
        backend.close()
    return Shot(folder)


def record_frames(
    backend: RecordingBackend,
    frames: Sequence[int],
    folder: Path,
    interrupt: Interrupt,
    tick: Callable[[int], None] = lambda _frame: None,
) -> None:
    """Records the frames of the file that `backend` has open; `tick` is called after each."""
    backend.begin_recording(folder)
    is_complete = False
    try:
        for frame in frames:
            interrupt.check()
            backend.record_frame(frame)
            tick(frame)
        is_complete = True
    finally:
        backend.end_recording(is_complete)
