"""Frame lists as people write them: `1-100`, `1,5,9-20`, `-5-10`."""

from __future__ import annotations

import re
from collections.abc import Iterable

MOST_FRAMES = 1_000_000
_PART = re.compile(r"\s*(-?\d+)\s*(?:-\s*(-?\d+)\s*)?")


def parse_frames(text: str) -> list[int]:
    """Ascending frame numbers without repeats; ValueError says what is wrong with `text`."""
    frames: set[int] = set()
    for part in text.split(","):
        first, last = _parse_part(part)
        if last - first >= MOST_FRAMES:
            raise ValueError(f"{part!r} is more than {MOST_FRAMES} frames")
        frames.update(range(first, last + 1))
    return sorted(frames)


def _parse_part(part: str) -> tuple[int, int]:
    match = _PART.fullmatch(part)
    if not match:
        raise ValueError(f"{part!r} is no frame or range; write 1-100 or 1,5,9-20")
    first = int(match[1])
    last = first if match[2] is None else int(match[2])
    if last < first:
        raise ValueError(f"{part.strip()!r} runs backwards")
    return first, last


def format_frames(frames: Iterable[int]) -> str:
    """The shortest text that `parse_frames` reads back as the same frames."""
    runs: list[list[int]] = []
    for frame in sorted(set(frames)):
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in runs)
