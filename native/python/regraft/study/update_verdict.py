"""What a person should do after `study update`, in one sentence that its table bears out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study.update import ENOUGH, YARDSTICK, yardstick

Row = dict[str, Any]
# What `auto` may cost more than the fastest before another policy is worth choosing by hand.
TOLERANCE = 1.05
# A tree this much worse than a fresh one is not said to be kept.
ENOUGH_FOR_ALL = 1.5
# Below this share of tracing, updating does not matter.
NEGLIGIBLE = 0.01


def choose(rows: Sequence[Row]) -> Row:
    """The row of `totals` to recommend: `auto` unless another is clearly faster."""
    trees = [r for r in rows if r["structure"] == "bvh" and r["given_up_after"] is None]
    fastest = min(trees, key=lambda row: row["total_s"])
    close = [
        row
        for row in trees
        if row["policy"] == "auto" and row["total_s"] <= TOLERANCE * fastest["total_s"]
    ]
    return min(close, key=lambda row: row["total_s"]) if close else fastest


def sentence(rows: Sequence[Row]) -> str:
    """From the rows of `totals`."""
    rebuilt = yardstick(rows)
    if not any(row["nodes_refitted"] + row["nodes_rebuilt"] for row in rows):
        return "No tree changes after the first frame of this shot: any policy will do."
    if rebuilt["update_s"] < NEGLIGIBLE * rebuilt["trace_s"]:
        return (
            f"Even rebuilding takes only {_percent(rebuilt['update_s'], rebuilt['trace_s'])} "
            "of the time of tracing in this shot: any policy will do, leave it on auto."
        )
    chosen = choose(rows)
    # Of refit all is said where it is the choice.
    of_refit = _of_refit(rows) if chosen["policy"] != "refit" else ""
    return "; ".join(filter(None, (_of_chosen(chosen), of_refit, _advice(chosen, rows))))


def _of_chosen(row: Row) -> str:
    if row["policy"] == YARDSTICK:
        return "Rebuilding every frame is the fastest for this shot"
    share = _percent(row["update_share"], 1.0)
    if row["ratio_worst"] > ENOUGH_FOR_ALL:
        return (
            f"{row['label']} is the fastest for this shot, at {share} of the time of rebuilding, "
            f"though its rays need {row['ratio_median']:.2f}× the tests of a fresh tree "
            f"(at worst {row['ratio_worst']:.2f}×, in frame {row['worst_frame']})"
        )
    return (
        f"{row['label']} keeps this shot within {row['ratio_worst']:.2f}× of a fresh tree "
        f"at {share} of the time of rebuilding"
    )


def _of_refit(rows: Sequence[Row]) -> str:
    row = next((row for row in rows if row["policy"] == "refit"), None)
    if row is None:
        return ""
    if row["enough_until"] is not None:
        return (
            f"refit is not enough after frame {row['enough_until']} "
            f"(rays then need more than {ENOUGH:g}× the tests, at worst {row['ratio_worst']:.2f}×)"
        )
    return f"refit alone is enough (at worst {row['ratio_worst']:.2f}× the tests)"


def _advice(chosen: Row, rows: Sequence[Row]) -> str:
    auto = next((r for r in rows if r["policy"] == "auto" and r["structure"] == "bvh"), None)
    if chosen["policy"] == "auto" or auto is None:
        return f"use {chosen['label']}: {_speed(chosen)}"
    if auto["given_up_after"] is not None:
        return f"choose {chosen['label']}"
    saved = _percent(auto["total_s"] - chosen["total_s"], auto["total_s"])
    return f"choose {chosen['label']}, which saves {saved} of what auto takes"


def _speed(row: Row) -> str:
    return f"{row['speed_up']:.2f}× as fast as rebuilding, update and trace together"


def _percent(part: float, whole: float) -> str:
    share = 100.0 * part / whole
    return f"{share:.0f} %" if share >= 1.0 else f"{share:.1f} %"
