"""What mending costs as a model grows of which the same small part moves."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Any

import regraft
from regraft.study import local_motion

Row = dict[str, Any]
SIZES = (100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)
MOVING, FRAMES, PICTURE = 2_000, 10, 256


def measure(sizes: Sequence[int], threads: int, tick: Callable[[int], None]) -> Iterator[Row]:
    """One row for each model of `sizes` triangles: medians over the frames after the first."""
    for size in sizes:
        with tempfile.TemporaryDirectory() as folder:
            shot = local_motion.make(Path(folder), size, MOVING, FRAMES)
            scene = regraft.Scene(threads=threads)
            selects, updates, rebuilt = [], [], []
            for position in range(len(shot)):
                shot.apply(position, scene)
                updated = scene.update(policy="selective", frames_left=len(shot) - position)
                scene.render(shot.camera(position), PICTURE, PICTURE)
                if position:
                    selects.append(updated.select_ms)
                    updates.append(updated.update_ms)
                    rebuilt.append(updated.nodes_rebuilt)
        tick(size)
        yield {
            "triangles": size,
            "select_ms": median(selects),
            "select_total_ms": sum(selects),
            "update_ms": median(updates),
            "nodes_rebuilt": sum(rebuilt),
        }


def slope(rows: Sequence[Row], name: str) -> float:
    """Least-squares slope of log(row[name]) over log(triangles)."""
    x = [math.log(row["triangles"]) for row in rows]
    y = [math.log(max(row[name], 1e-3)) for row in rows]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    above = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True))
    return above / sum((a - mean_x) ** 2 for a in x)


def lines(rows: Sequence[Row]) -> Iterator[str]:
    """A table with its slopes."""
    yield f"  {'triangles':>12}{'mending ms':>12}{'all frames':>12}{'update ms':>11}{'rebuilt':>10}"
    for row in rows:
        yield (
            f"  {row['triangles']:>12}{row['select_ms']:>12.3f}{row['select_total_ms']:>12.2f}"
            f"{row['update_ms']:>11.2f}{row['nodes_rebuilt']:>10}"
        )
    if len(rows) > 1:
        yield f"  slope of mending over size, log-log: {slope(rows, 'select_total_ms'):.2f}"
