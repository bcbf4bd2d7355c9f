"""Ctrl-C and SIGTERM: the first asks to finish, the second ends at once."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from regraft.cli.console import Console
from regraft.cli.errors import EXIT_INTERRUPTED, InterruptedRunError

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupt:
    """Whether someone asked to stop. `temporary` is the file or folder to remove if the
    end is abrupt."""

    def __init__(self, console: Console) -> None:
        self.asked = False
        self.temporary: Path | None = None
        self._console = console

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        if self.asked:
            # Raising here could end up inside a callback of Blender's, which would swallow it.
            if self.temporary and self.temporary.is_dir():
                shutil.rmtree(self.temporary, ignore_errors=True)
            elif self.temporary:
                self.temporary.unlink(missing_ok=True)
            os._exit(EXIT_INTERRUPTED)
        self.asked = True
        self._console.warn("finishing this frame; once more ends at once")

    def check(self) -> None:
        """Raises InterruptedRunError if someone asked to stop."""
        if self.asked:
            raise InterruptedRunError("interrupted")

    @contextmanager
    def watching(self) -> Iterator[Interrupt]:
        """Takes the signals over for the block."""
        before = [signal.signal(number, self._on_signal) for number in _SIGNALS]
        try:
            yield self
        finally:
            for number, handler in zip(_SIGNALS, before, strict=True):
                signal.signal(number, handler)
