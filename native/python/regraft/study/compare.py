"""Two runs of one shot, from their statistics: which frames differ most, and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import median
from typing import Any

Row = dict[str, Any]
STAGES = ("evaluate_ms", "extract_ms", "update_ms", "trace_ms", "shade_ms", "write_ms")
# What explains a stage's time, the best explanation first.
CAUSES = {
    "evaluate_ms": (),
    "extract_ms": ("deformed_triangles", "moved_instances", "triangles"),
    "update_ms": ("nodes_rebuilt", "nodes_refitted", "pairs_considered", "deformed_triangles"),
    "trace_ms": (
        "triangle_tests",
        "nodes_visited",
        "rays_shadow",
        "rays_secondary",
        "rays_primary",
    ),
    "shade_ms": ("rays_secondary", "rays_shadow", "rays_primary"),
    "write_ms": (),
}
# A count that differs by less explains nothing.
NOTABLE = 0.02


def pair(a: Sequence[Row], b: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Rows of the same frame, and of the same scene, policy, … where files hold several a frame."""
    keys = ["frame"]
    for name in ("scene", "structure", "layout", "policy"):
        if len({tuple(row.get(k) for k in keys) for row in a}) < len(a):
            keys.append(name)
    found = {tuple(row.get(k) for k in keys): row for row in b}
    matches = ((row, found.get(tuple(row.get(k) for k in keys))) for row in a)
    return [(mine, other) for mine, other in matches if other is not None]


def total_ms(row: Mapping[str, Any]) -> float:
    """Of the frame; the sum of its stages where it is not stated."""
    return float(row.get("total_ms") or sum(row.get(stage) or 0.0 for stage in STAGES))


def differences(pairs: Sequence[tuple[Row, Row]]) -> list[Row]:
    """A row for each frame, what differs most first."""
    rows = [_difference(a, b) for a, b in pairs]
    return sorted(rows, key=lambda row: -abs(row["difference_ms"]))


def _difference(a: Row, b: Row) -> Row:
    by_stage = {s: (b.get(s) or 0.0) - (a.get(s) or 0.0) for s in STAGES}
    stage = max(by_stage, key=lambda s: abs(by_stage[s]))
    return {
        "frame": a["frame"],
        "a_ms": total_ms(a),
        "b_ms": total_ms(b),
        "difference_ms": total_ms(b) - total_ms(a),
        **by_stage,
        "stage": stage.removesuffix("_ms"),
        "why": "; ".join(reasons(a, b, stage)) or "no count differs: the machine",
    }


def reasons(a: Row, b: Row, stage: str) -> Iterator[str]:
    """Counts that explain the stage's difference; then what only one run left out or warned of.
    Nothing does where the library does not work: evaluating the scene, writing the file."""
    if not CAUSES[stage]:
        return
    for name in CAUSES[stage]:
        before, after = a.get(name) or 0, b.get(name) or 0
        if abs(after - before) > NOTABLE * max(before, after):
            yield f"{name} {before:,} → {after:,}"
    for name, words in (("left_out", "left out"), ("warnings", "warned")):
        mine, other = (_sentences(row, name) for row in (a, b))
        yield from (f"only A {words}: {s}" for s in sorted(mine - other))
        yield from (f"only B {words}: {s}" for s in sorted(other - mine))


def _sentences(row: Row, name: str) -> set[str]:
    # The numbers in a sentence may differ from frame to frame; that they do is no cause.
    return {s for s in row.get(name) or () if isinstance(s, str)}


def sentence(rows: Sequence[Row]) -> str:
    """The verdict, from the rows of `differences`."""
    before, after = (median(row[k] for row in rows) for k in ("a_ms", "b_ms"))
    stages = {s: median(row[s] for row in rows) for s in STAGES}
    stage = max(stages, key=lambda s: abs(stages[s]))
    worst = rows[0]
    return (
        f"B takes {_relation(before, after)} over {len(rows)} frames "
        f"(median {after:.1f} against {before:.1f} ms), most of it in "
        f"{stage.removesuffix('_ms')} ({stages[stage]:+.1f} ms); frame {worst['frame']} differs "
        f"most: {worst['difference_ms']:+.1f} ms, {worst['stage']}: {worst['why']}"
    )


def _relation(before: float, after: float) -> str:
    if before <= 0.0 or after <= 0.0:
        return "another time"
    return f"{after / before:.2f}× the time of A"
