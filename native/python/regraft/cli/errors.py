"""What can go wrong, each with the exit code that scripts may trust."""

from __future__ import annotations

import errno
import shutil
from pathlib import Path

EXIT_OK = 0
EXIT_INTERRUPTED = 130


class CommandError(Exception):
    """Ends the command with `exit_code` and its text as the message."""

    exit_code = 1


class SelfCheckError(CommandError):
    """A self-check failed."""

    exit_code = 1


class UsageError(CommandError):
    """The command was asked for something it cannot mean."""

    exit_code = 2


class InputError(CommandError):
    """The input is bad or unreadable, or nothing here can read it."""

    exit_code = 3


class OutputError(CommandError):
    """The output could not be written."""

    exit_code = 4


class InterruptedRunError(CommandError):
    """The user or the scheduler asked to stop."""

    exit_code = EXIT_INTERRUPTED


def describe_write_failure(target: Path, error: Exception) -> OutputError:
    """An OutputError that names `target`, the cause and, if the disk is full, what is left."""
    cause = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    free = free_megabytes(target)
    full = isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)
    if full or (free is not None and free < 1.0):
        cause = f"{cause} (disk full? {free or 0.0:.1f} MB free)"
    return OutputError(f"cannot write {target}: {cause}")


def free_megabytes(target: Path) -> float | None:
    """Space left on the file system that holds `target`, or None if nobody knows."""
    try:
        usage = shutil.disk_usage(target if target.is_dir() else target.parent)
    except OSError:
        return None
    return usage.free / 1e6 if usage.total else None
