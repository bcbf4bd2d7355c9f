"""What a measurement must be read with: the machine it was made on; and where it is kept."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import regraft
from regraft.cli.doctor import available_isas, usable_cores
from regraft.cli.errors import describe_write_failure
from regraft.formats import atomic, jsonl


def save_result(path: Path, result: dict[str, Any]) -> None:
    """Writes a benchmark's result as JSON. Raises OutputError."""
    try:
        atomic.write_bytes(path, jsonl.encode(result))
    except OSError as error:
        raise describe_write_failure(path, error) from error


def machine_line(result: dict[str, Any]) -> str:
    """The machine in one line for people."""
    return (
        f"{result['processor']}, {result['cores']} cores, {result['simd']}, load "
        f"{result['load_average']}; regraft {result['regraft']} {result['commit']}".rstrip()
    )


def machine() -> dict[str, Any]:
    """What a measurement must be read with."""
    return {
        "regraft": regraft.__version__,
        "commit": _commit(),
        "processor": _processor(),
        "cores": usable_cores(),
        "simd": available_isas()[-1],
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }


def _commit() -> str:
    """Commit of regraft's checkout that this package lies in, `+` for changes; else ""."""
    folder = Path(regraft.__file__).resolve().parent
    top = _git(folder, "rev-parse", "--show-toplevel")
    if not top or not Path(top, "native", "regraft").is_dir():
        return ""
    return _git(folder, "describe", "--always", "--dirty=+", "--exclude=*")


def _git(folder: Path, *words: str) -> str:
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *words], capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def _processor() -> str:
    """Name of the processor where the system tells it, else its architecture."""
    import platform

    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
