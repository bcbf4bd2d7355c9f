"""Makes a shot of a file, through Blender."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from regraft.cli.backend import choose_backend
from regraft.cli.console import Console
from regraft.cli.errors import InputError
from regraft.cli.job import RenderJob
from regraft.study.shot import Shot

# What is drawn meanwhile is thrown away; its shape is that of the pictures the shot is traced in.
SIZE = (64, 64)


def record(
    source: Path, folder: Path, frames: Sequence[int] | None, verbose: bool, console: Console
) -> Shot:
    """The frames of the file (all if None) as a shot in `folder`, which exists.

    Raises the errors of a render, and InputError for frames the file does not have.
    """
    backend = choose_backend(verbose)
    try:
        job = RenderJob(str(source), *SIZE, shading="clay", policy="refit")
        info = backend.open(job)
        for note in info.notes:
            console.note(note)
        wanted = info.frames if frames is None else tuple(f for f in info.frames if f in frames)
        if not wanted:
            raise InputError(f"{source} has none of the frames asked for")
        backend.record(wanted, folder)
    finally:
        backend.close()
    return Shot(folder)
