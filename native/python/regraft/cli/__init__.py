"""The `regraft` command. Modules named blender_* run inside Blender and import bpy on use."""

from __future__ import annotations

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command and returns its exit code (see `regraft -h`)."""
    from regraft.cli.command import run

    return run(arguments)
