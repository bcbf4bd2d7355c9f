"""The last lines of a render: what a frame cost, and what it did not need."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from statistics import median
from typing import Any

from regraft.cli.frame_range import format_frames

STAGES = ("evaluate", "extract", "update", "trace", "shade", "write", "total")
_MOST_LEFT_OUT = 4


def frame_line(row: dict[str, Any], name: str) -> str:
    """One frame in one line."""
    cost = ", ".join(f"{stage} {row.get(f'{stage}_ms') or 0.0:.0f}" for stage in STAGES[:-1])
    return f"{name}: {row.get('total_ms') or 0.0:.0f} ms ({cost})"


# What a frame may have to do: a sentence, and the counts in it that must not all be 0.
_WORK = (
    (
        "changed: {deformed_meshes:,} meshes of {deformed_triangles:,} triangles deformed, "
        "{moved_instances:,} instances moved",
        ("deformed_meshes", "moved_instances"),
    ),
    (
        "trees ({policy}, {structure}, {layout}): {nodes_refitted:,} of {nodes:,} nodes refitted, "
        "{nodes_rebuilt:,} rebuilt, {pairs_restructured:,} of {pairs_considered:,} pairs mended",
        ("nodes_refitted", "nodes_rebuilt", "pairs_considered"),
    ),
    (
        "late: {late_updates:,} trees brought up to date when rays came near, in "
        "{late_update_ms:.1f} ms",
        ("late_updates",),
    ),
    ("k-d tree: {kdtree_nodes:,} nodes built", ("kdtree_nodes",)),
    (
        "rays: {rays_primary:,} primary, {rays_shadow:,} shadow, {rays_secondary:,} secondary",
        ("rays_primary",),
    ),
)


def plan(row: dict[str, Any]) -> list[str]:
    """A frame's plan, a line each: what changed, what was done about it, what was left out."""
    known = defaultdict(int, row)
    needed = (words.format_map(known) for words, counts in _WORK if any(known[c] for c in counts))
    left_out = (f"left out: {words}" for words in row.get("left_out") or ())
    return [*needed, *left_out]


def summarise(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Two lines: median milliseconds a frame by stage, and what was left out."""
    if not rows:
        return []
    medians = " | ".join(f"{stage} {_median(rows, stage):.1f}" for stage in STAGES)
    return [f"median ms a frame: {medians}", f"left out: {_left_out(rows)}"]


def warnings(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Each warning once, with the frames it belongs to."""
    frames: dict[str, list[int]] = {}
    for row in rows:
        for words in row.get("warnings") or ():
            frames.setdefault(words, []).append(row["frame"])
    return [f"{words} (frames {format_frames(where)})" for words, where in frames.items()]


def _median(rows: Sequence[dict[str, Any]], stage: str) -> float:
    return median(row.get(f"{stage}_ms") or 0.0 for row in rows)


def _left_out(rows: Sequence[dict[str, Any]]) -> str:
    counts = Counter(words for row in rows for words in row.get("left_out") or ())
    if not counts:
        return "nothing"
    common = counts.most_common(_MOST_LEFT_OUT)
    return "; ".join(f"{words} ({n} of {len(rows)} frames)" for words, n in common)
