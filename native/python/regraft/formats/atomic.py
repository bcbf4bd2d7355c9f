"""Files appear under their final name whole or not at all.

A writer works on a temporary file in the same folder; `commit` makes it durable and puts it in
place. All functions raise OSError.
"""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_STRAY = re.compile(r"\..+\.regraft-(?P<host>[^.]*)-(?P<pid>\d+)(?:\.\w+)?")


def temporary_path(target: Path) -> Path:
    """Hidden name beside `target` with the same ending, marked with this machine and process."""
    return target.with_name(f".{target.stem}.regraft-{_host()}-{os.getpid()}{target.suffix}")


def commit(temporary: Path, target: Path) -> None:
    """Makes `temporary` durable, then gives it the name `target` in one step."""
    _sync(temporary, os.O_RDWR)
    os.replace(temporary, target)
    if os.name == "posix":
        _sync(target.parent, os.O_RDONLY)


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Yields a temporary path to fill; it becomes `target` if the block ends without error."""
    temporary = temporary_path(target)
    try:
        yield temporary
        commit(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(target: Path, content: bytes) -> None:
    """Replaces the content of `target` in one step."""
    with replacing(target) as temporary:
        temporary.write_bytes(content)


def prepare_folder(folder: Path) -> None:
    """Makes `folder`, proves that a file can be written in it, and clears what dead runs left."""
    folder.mkdir(parents=True, exist_ok=True)
    with probe(folder / "probe"):
        pass
    for path in folder.iterdir():
        if _is_stray(path.name):
            path.unlink(missing_ok=True)


@contextmanager
def probe(target: Path) -> Iterator[None]:
    """Raises OSError at once if a file could not be written beside `target`."""
    temporary = temporary_path(target)
    try:
        temporary.write_bytes(b"regraft")
        yield
    finally:
        temporary.unlink(missing_ok=True)


def _sync(path: Path, flags: int) -> None:
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9_]", "_", socket.gethostname())


def _is_stray(name: str) -> bool:
    """A temporary file of a process of this machine that no longer runs."""
    match = _STRAY.fullmatch(name)
    return match is not None and match["host"] == _host() and not _is_alive(int(match["pid"]))


def _is_alive(pid: int) -> bool:
    if os.name != "posix":  # elsewhere signal 0 is no harmless question
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
