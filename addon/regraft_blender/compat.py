"""Where the native library is found, and what differs between the Blender versions."""

from __future__ import annotations

import importlib
import logging
import math
import sys
from pathlib import Path
from types import ModuleType

import bpy

log = logging.getLogger(__name__)

# The package for Blender 3.4 carries the library here; extensions and wheels install it.
BUNDLED = Path(__file__).parent / "lib"

# `rect.foreach_set` takes one row a pixel up to 3.x and one flat array from 4.0 on.
FLAT_RESULT_PIXELS = bpy.app.version >= (4, 0, 0)

# Until 4.0 an area light's watts were turned into radiance with a 4 where a π belongs; files are
# converted when newer versions open them, so that they look the same.
AREA_LIGHT_POWER = 1.0 if bpy.app.version >= (4, 0, 0) else math.pi / 4

_state: dict[str, ModuleType | str] = {}


class NativeMissingError(RuntimeError):
    """The native library could not be loaded; the message says why, for a user to read."""


def native() -> ModuleType:
    """The module `regraft`. Raises NativeMissingError; tries to load it only once."""
    if not _state:
        _load()
    if "module" not in _state:
        raise NativeMissingError(str(_state["problem"]))
    module = _state["module"]
    assert isinstance(module, ModuleType)
    return module


def library_folder() -> str:
    """From where Python imports the library. Raises NativeMissingError."""
    return str(Path(str(native().__file__)).parents[1])


def problem() -> str:
    """Why the native library cannot be used, or an empty string."""
    try:
        native()
    except NativeMissingError as error:
        return str(error)
    return ""


def forget() -> None:
    """Make the next `native()` look for the library again."""
    _state.clear()


def _load() -> None:
    if BUNDLED.is_dir() and str(BUNDLED) not in sys.path:
        sys.path.append(str(BUNDLED))
    try:
        _state["module"] = importlib.import_module("regraft")
    except (ImportError, OSError) as error:
        _state["problem"] = f"The native library 'regraft' could not be loaded: {error}"
        log.error("%s", _state["problem"])
