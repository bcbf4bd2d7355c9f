"""Blender in this very process, as the Python module bpy."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from regraft.cli.blender_worker import BlenderWorker
from regraft.cli.job import RenderJob, SceneInfo

_OUTPUTS = (1, 2)


class InProcessBackend:
    """Calls the worker directly and holds back what Blender prints on its own."""

    place = "bpy, in this process"

    def __init__(self, verbose: bool) -> None:
        self._worker = BlenderWorker()
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

    def close(self) -> None:
        """See BlenderWorker.close."""
        with hold_back_output(self._verbose):
            self._worker.close()


@contextmanager
def hold_back_output(verbose: bool) -> Iterator[None]:
    """Sends what C and Python code writes to stdout and stderr to nowhere, unless `verbose`.

    If the block fails it comes out on stderr after all: it may hold the traceback that explains.
    """
    if verbose:
        yield
        return
    with tempfile.TemporaryFile() as held:
        saved = _redirect(held)
        try:
            yield
        except BaseException:
            _restore(saved)
            _replay(held)
            raise
        _restore(saved)


def _redirect(target: BinaryIO) -> list[int]:
    _flush()
    saved = [os.dup(fd) for fd in _OUTPUTS]
    for fd in _OUTPUTS:
        os.dup2(target.fileno(), fd)
    return saved


def _restore(saved: list[int]) -> None:
    if saved:
        _flush()
        for fd, old in zip(_OUTPUTS, saved, strict=True):
            os.dup2(old, fd)
            os.close(old)


def _replay(held: BinaryIO) -> None:
    held.seek(0)
    text = held.read().decode(errors="replace")
    wanted = text[text.find("Traceback") :] if "Traceback" in text else ""
    sys.stderr.write(wanted)
    sys.stderr.flush()


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()
