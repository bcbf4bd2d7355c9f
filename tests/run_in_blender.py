"""Runs inside a Blender: [--addon] SCRIPT ARGUMENT... or --install PACKAGE.

SCRIPT runs as `__main__` with its arguments in `sys.argv[1:]`, with our add-on enabled where
--addon says so. Modules beside SCRIPT can be imported. Any exception ends the process with an exit
code other than 0.
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import bpy

EXTENSION = "bl_ext.user_default.regraft_blender"
LEGACY = "regraft_blender"
IS_LEGACY = bpy.app.version < (4, 2, 0)


def install(package: str) -> None:
    """Put the package into this process's profile, as the user's click would."""
    if IS_LEGACY:
        bpy.ops.preferences.addon_install(filepath=package)
    else:
        bpy.ops.extensions.package_install_files(
            filepath=package, repo="user_default", enable_on_install=True
        )


def enable() -> None:
    """Enable the installed add-on for this process."""
    name = LEGACY if IS_LEGACY else EXTENSION
    bpy.ops.preferences.addon_enable(module=name)
    if name not in bpy.context.preferences.addons:
        sys.exit(f"{name} could not be enabled")


def main(words: list[str]) -> None:
    if words[0] == "--install":
        install(words[1])
        enable()
        return
    if words[0] == "--addon":
        enable()
        words = words[1:]
    sys.argv = words
    sys.path.insert(0, str(Path(words[0]).parent))
    runpy.run_path(words[0], run_name="__main__")


main(sys.argv[sys.argv.index("--") + 1 :])
