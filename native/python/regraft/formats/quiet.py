"""Keeps what libraries print on their own away from the user's terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

_OUTPUTS = (1, 2)


@contextmanager
def hold_back_output(verbose: bool = False) -> Iterator[None]:
    """Sends what C and Python code writes to stdout and stderr to nowhere, unless `verbose`."""
    if verbose:
        yield
        return
    with open(os.devnull, "wb") as nowhere:
        saved = _redirect(nowhere)
        try:
            yield
        finally:
            _restore(saved)


def silence_outputs() -> None:
    """Sends all further output to nowhere: for the very end of a process."""
    _flush()
    with open(os.devnull, "wb") as nowhere:
        for fd in _OUTPUTS:
            os.dup2(nowhere.fileno(), fd)


def _redirect(target: BinaryIO) -> list[int]:
    _flush()
    saved = [os.dup(fd) for fd in _OUTPUTS]
    for fd in _OUTPUTS:
        os.dup2(target.fileno(), fd)
    return saved


def _restore(saved: list[int]) -> None:
    _flush()
    for fd, old in zip(_OUTPUTS, saved, strict=True):
        os.dup2(old, fd)
        os.close(old)


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()
