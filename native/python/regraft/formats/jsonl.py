"""JSON Lines that survive a kill: a line is there whole or not at all."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from regraft.formats import atomic

Row = dict[str, Any]

# Microseconds, where the unit is milliseconds; enough for ratios too.
_DECIMALS = 6


def read(path: Path) -> list[Row]:
    """All whole rows; none if there is no file. Lines that are no JSON object are left out."""
    if not path.exists():
        return []
    rows = (_parse(line) for line in path.read_bytes().split(b"\n"))
    return [row for row in rows if row is not None]


def rewrite(path: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Replaces the file by these rows in one step."""
    atomic.write_bytes(path, b"".join(encode(row) for row in rows))


def append(path: Path, row: Mapping[str, Any]) -> None:
    """Adds one row and makes it durable; on failure the file is as it was. Raises OSError."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        before = _end_of_last_line(descriptor)
        os.ftruncate(descriptor, before)
        try:
            _write_all(descriptor, encode(row))
        except OSError:
            os.ftruncate(descriptor, before)
            raise
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def encode(row: Mapping[str, Any]) -> bytes:
    """One line of strict JSON: floats are rounded, infinities and NaN become null."""
    return json.dumps(_plain(row), ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _parse(line: bytes) -> Row | None:
    try:
        row = json.loads(line)
    except ValueError:
        return None
    return row if isinstance(row, dict) else None


def _end_of_last_line(descriptor: int) -> int:
    """Offset behind the last newline, where the descriptor then stands: a torn tail is cut."""
    size = os.lseek(descriptor, 0, os.SEEK_END)
    tail_start = max(0, size - 65536)
    os.lseek(descriptor, tail_start, os.SEEK_SET)
    end = tail_start + os.read(descriptor, 65536).rfind(b"\n") + 1
    return os.lseek(descriptor, end, os.SEEK_SET)


def _write_all(descriptor: int, content: bytes) -> None:
    written = 0
    while written < len(content):
        written += os.write(descriptor, content[written:])


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if hasattr(value, "item"):
        return _plain(value.item())
    if isinstance(value, float):
        return round(value, _DECIMALS) if math.isfinite(value) else None
    return value
