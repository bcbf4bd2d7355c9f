"""What this version of the library can do, asked of the library itself."""

from __future__ import annotations

from typing import Any

import regraft

POLICIES = ("refit", "rebuild", "lm", "rtdeform", "selective", "selective+rotate", "shot", "auto")
STRUCTURES = ("bvh", "kdtree")
LAYOUTS = ("two-level", "flat")


def policies() -> tuple[str, ...]:
    """Policies of the library's contract that are there, the simplest first."""
    return tuple(name for name in POLICIES if _has({"policy": name}))


def structures() -> tuple[str, ...]:
    """Structures of the library's contract that are there."""
    return tuple(name for name in STRUCTURES if _has({"structure": name}))


def _has(choice: dict[str, Any]) -> bool:
    try:
        regraft.Scene(threads=1).update(**choice)
    except (NotImplementedError, ValueError):
        return False
    return True
