"""The measuring programs that `make bench` builds."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from regraft.cli.errors import InputError, SelfCheckError

FOLDER = Path("build/bench/native/bench")


def lines(program: Path, *arguments: str) -> Iterator[str]:
    """What the program prints, line by line but for blank ones; it ends with whoever reads.

    Raises InputError if there is no such program, SelfCheckError with its words if it fails.
    """
    if not program.is_file():
        raise InputError(f"cannot run {program}: no such file; `make bench` builds it")
    command = [str(program.resolve()), *arguments]
    with (
        tempfile.TemporaryFile("w+") as complaints,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=complaints, text=True) as running,
    ):
        try:
            assert running.stdout is not None
            yield from filter(str.strip, running.stdout)
        except BaseException:
            running.kill()
            raise
        if code := running.wait():
            complaints.seek(0)
            raise SelfCheckError(f"{program} failed with {code}: {complaints.read().strip()}")
