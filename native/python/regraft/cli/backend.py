"""Where Blender runs: in this process as bpy, or as the `blender` program beside it."""

from __future__ import annotations

import importlib
import logging
import os
import shutil
from pathlib import Path
from typing import Any, Protocol

from regraft.cli.errors import InputError
from regraft.cli.job import RenderJob, SceneInfo

LOG = logging.getLogger("regraft")

PROGRAM_VARIABLE = "REGRAFT_BLENDER"
HOW_TO_GET_BLENDER = (
    "no Blender to read the file with: install the Python package bpy (pip install "
    "'regraft[blender]') or put Blender's own `blender` program on the PATH"
)


class Backend(Protocol):
    """Opens one file and renders its frames; errors are those of regraft.cli.errors.

    `place` says for people where Blender runs.
    """

    place: str

    def probe(self) -> dict[str, Any]: ...

    def open(self, job: RenderJob) -> SceneInfo: ...

    def render(self, frame: int, path: Path) -> dict[str, Any]: ...

    def close(self) -> None: ...


class RecordingBackend(Backend, Protocol):
    """One that can also write the frames down as a shot (regraft.study.shot), and plan by one."""

    def begin_recording(self, folder: Path) -> None: ...

    def record_frame(self, frame: int) -> None: ...

    def end_recording(self, is_complete: bool) -> None: ...

    def plan(self, folder: Path) -> None: ...


def choose_backend(verbose: bool) -> RecordingBackend:
    """bpy if it can be imported, else the program `blender`; InputError if there is neither."""
    program = find_program()
    if program is None:
        from regraft.cli.backend_inprocess import InProcessBackend

        return InProcessBackend(verbose)
    from regraft.cli.backend_subprocess import SubprocessBackend, blender_command

    return SubprocessBackend(blender_command(program), verbose)


def find_program() -> str | None:
    """Path of the Blender program to run, or None for bpy in this process.

    The environment variable REGRAFT_BLENDER names a program to prefer. InputError if there is
    nothing.
    """
    if named := os.environ.get(PROGRAM_VARIABLE):
        if found := shutil.which(named):
            return found
        raise InputError(f"{PROGRAM_VARIABLE} names {named}, which is no program")
    if can_import_bpy():
        return None
    if found := shutil.which("blender"):
        return found
    raise InputError(HOW_TO_GET_BLENDER)


def can_import_bpy() -> bool:
    """Whether Blender is here as a Python module that really loads."""
    try:
        importlib.import_module("bpy")
    except ImportError as error:
        LOG.debug("bpy: %s", error)
        return False
    return True
