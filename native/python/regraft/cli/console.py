"""The one place where the command speaks to its user: results on stdout, the rest on stderr."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol, Self, TextIO

if TYPE_CHECKING:
    from tqdm import tqdm

LOG = logging.getLogger("regraft")


class Console:
    """Writes to the streams that were there when it was made, by descriptors of its own.

    It is therefore heard even while the output of Blender, in this process, is held back.
    """

    def __init__(self) -> None:
        self.out = _own_stream(sys.stdout)
        self.err = _own_stream(sys.stderr)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for stream, original in ((self.out, sys.stdout), (self.err, sys.stderr)):
            if stream is not original:
                stream.close()

    def say(self, text: str) -> None:
        """A line of result or progress."""
        self._line(self.out, text)

    def note(self, text: str) -> None:
        """Something the command decided on its own."""
        self._line(self.err, f"regraft: note: {text}")

    def warn(self, text: str) -> None:
        """Something the user should know, while the work goes on."""
        self._line(self.err, f"regraft: warning: {text}")

    def error(self, text: str) -> None:
        """Why the command ends."""
        self._line(self.err, f"regraft: error: {text}")

    def is_terminal(self) -> bool:
        """Whether somebody watches: a bar is drawn instead of lines."""
        return self.err.isatty()

    @contextmanager
    def progress(self, total: int, what: str) -> Iterator[Progress]:
        """A bar on a terminal, else one line a step. Ends with its block."""
        if not self.is_terminal():
            yield _Lines(self, total)
            return
        from tqdm import tqdm

        with tqdm(total=total, desc=what, unit="frame", file=self.err, dynamic_ncols=True) as bar:
            yield _Bar(self, bar)

    @staticmethod
    def _line(stream: TextIO, text: str) -> None:
        stream.write(text + "\n")
        stream.flush()


class Progress(Protocol):
    """Takes one step; `text` is a line of its own, `short` fits beside a bar. `say`: a line of
    result, bar or no bar."""

    def step(self, text: str, short: str) -> None: ...

    def say(self, text: str) -> None: ...


class _Lines:
    def __init__(self, console: Console, total: int) -> None:
        self._console, self._total, self._done = console, total, 0

    def step(self, text: str, short: str) -> None:
        self._done += 1
        self._console.say(f"[{self._done}/{self._total}] {text}")

    def say(self, text: str) -> None:
        self._console.say(text)


class _Bar:
    def __init__(self, console: Console, bar: tqdm) -> None:
        self._console, self._bar = console, bar

    def say(self, text: str) -> None:
        self._bar.clear()
        self._console.say(text)
        self._bar.refresh()

    def step(self, text: str, short: str) -> None:
        self._bar.set_postfix_str(short, refresh=False)
        self._bar.update(1)


def _own_stream(stream: TextIO) -> TextIO:
    try:
        descriptor = os.dup(stream.fileno())
    except (OSError, ValueError):  # replaced by something that is no file
        return stream
    return os.fdopen(descriptor, "w", encoding=stream.encoding, errors="backslashreplace")


def start_logging(verbose: bool) -> None:
    """Library messages go to stderr: warnings, or everything when `verbose`."""
    logging.basicConfig(
        level=logging.DEBUG if verbose else logging.WARNING,
        format="regraft: %(levelname)s: %(message)s",
        stream=sys.stderr,
    )
