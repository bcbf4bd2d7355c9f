"""Where Blender runs: in this process as bpy, or as the `blender` program beside it."""

from __future__ import annotations

import importlib
import logging
import shutil
from pathlib import Path
from typing import Any, Protocol

from regraft.cli.errors import InputError
from regraft.cli.job import RenderJob, SceneInfo

LOG = logging.getLogger("regraft")

HOW_TO_GET_BLENDER = (
    "no Blender to read the file with: install the Python package bpy (pip install "
    "'regraft[blender]') or put Blender's own `blender` program on the PATH"
)


class Backend(Protocol):
    """Opens one file and renders its frames; errors are those of regraft.cli.errors."""

    def open(self, job: RenderJob) -> SceneInfo: ...

    def render(self, frame: int, path: Path) -> dict[str, Any]: ...

    def close(self) -> None: ...


def choose_backend(verbose: bool) -> Backend:
    """bpy if it can be imported, else the program `blender`; InputError if there is neither."""
    if can_import_bpy():
        from regraft.cli.backend_inprocess import InProcessBackend

        return InProcessBackend(verbose)
    program = shutil.which("blender")
    if program is None:
        raise InputError(HOW_TO_GET_BLENDER)
    from regraft.cli.backend_subprocess import SubprocessBackend, blender_command

    return SubprocessBackend(blender_command(program), verbose)


def can_import_bpy() -> bool:
    """Whether Blender is here as a Python module that really loads."""
    try:
        importlib.import_module("bpy")
    except ImportError as error:
        LOG.debug("bpy: %s", error)
        return False
    return True
