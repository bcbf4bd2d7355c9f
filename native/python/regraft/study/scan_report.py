"""`study scan` as a section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study import plots, scan
from regraft.study.page import Section, Table

Row = dict[str, Any]
# Trees up to this many times as dear as that of exact splits are as good.
AS_GOOD = 1.01
# Errors below this are drawn as if they were this: the axis is logarithmic.
_LEAST_ERROR = 1e-6
COLUMNS = {
    "splits": "splits",
    "build_s": "build, s",
    "build_s_low": "quartiles: from",
    "build_s_high": "to",
    "trace_s": "trace, s",
    "total_s": "both, s",
    "sam_ratio": "tree's cost / exact",
    "worst_excess": "worst error",
    "mean_excess": "mean",
    "worst_certificate": "worst proven",
    "mean_certificate": "mean",
    "mean_samples": "planes tried",
    "nodes": "nodes",
    "nodes_visited": "nodes visited",
    "triangle_tests": "triangle tests",
}


def section(name: str, rows: Sequence[Row], table: Sequence[Row]) -> Section:
    """Of one scene, from the rows of `scan.measure` and their `scan.table`."""
    wrong = scan.different_hits(rows)
    verdict = sentence(table)
    if wrong:
        verdict = f"Trees of {', '.join(dict.fromkeys(wrong))} hit other things than the first."
    found = Section(name, verdict, bool(wrong))
    found.tables.append(Table(COLUMNS, table, table.index(cheapest(table))))
    found.notes += [
        f"Medians of {len(rows) // max(len(table), 1)} builds taking turns; the tree of all "
        "triangles at once, no seeds of the scene's hierarchy.",
        "k: two passes of k − 1 planes an axis. ε: planes until the one chosen is proven to cost "
        "at most 1 + ε times the least; from how many it starts does not matter then.",
        f"Errors are over the least cost, less 1, at {_nodes(table)} nodes of the exact tree; "
        "nodes of few triangles, which scans sort, and cuts of empty space do not count.",
    ]
    _draw_errors(name, table, found.plots)
    _draw_times(name, table, found.plots)
    return found


def _nodes(table: Sequence[Row]) -> str:
    return f"{max(row.get('nodes_compared', 0) for row in table):,}"


def cheapest(table: Sequence[Row]) -> Row:
    """The row with the shortest build and picture whose tree is as good as the exact one."""
    good = [row for row in table if row["sam_ratio"] <= AS_GOOD]
    return min(good, key=lambda row: row["total_s"])


def sentence(table: Sequence[Row]) -> str:
    """Which setting this scene wants, and what it saves and costs."""
    rows = {row["splits"]: row for row in table}
    exact, best = rows[scan.EXACT], cheapest(table)
    if exact["nodes"] <= 1:
        return "This scene is too small to be split."
    parts = [
        f"Use {best['splits']}: its tree and picture take {_times(best, exact)} of the time with "
        f"exact splits, and the tree costs {best['sam_ratio']:.3f}× as much",
        *_safe_planes(table),
    ]
    default = rows.get(scan.DEFAULT)
    if default is not None and default is not best:
        parts.append(
            f"the default, {scan.DEFAULT}, takes {_times(default, exact)} for "
            f"{default['sam_ratio']:.3f}× the cost, no error above "
            f"{max(default['worst_excess'], 0.0):.1%}"
        )
    return "; ".join(parts)


def _times(row: Row, base: Row) -> str:
    return f"{row['total_s'] / max(base['total_s'], 1e-9):.0%}"


def _safe_planes(table: Sequence[Row]) -> list[str]:
    fixed = [row for row in table if row["planes"]]
    safe = [row for row in fixed if row["sam_ratio"] <= AS_GOOD]
    if not safe:
        return ["no fixed number of planes makes as good a tree"]
    least = min(safe, key=lambda row: row["planes"])
    return [
        f"of fixed numbers of planes {least['splits']} is the least that is as good, with errors "
        f"up to {least['worst_excess']:.1%} at single nodes"
    ]


def _draw_errors(name: str, table: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "What error is left after how long a build; whoever is lower and further left wins."
    with plots.drawing(f"{name}_scan_errors", caption, into) as axes:
        for i, (key, text) in enumerate((("worst_excess", "worst"), ("mean_excess", "mean"))):
            mine = [row for row in table if row["splits"] != scan.EXACT]
            x = [row["build_s"] for row in mine]
            y = [max(row[key], _LEAST_ERROR) for row in mine]
            axes.plot(x, y, "o^"[i], color=plots.colour(text, i), label=f"{text} error")
        for row in mine:
            place = (row["build_s"], max(row["mean_excess"], _LEAST_ERROR))
            axes.annotate(
                row["splits"], place, xytext=(5, 3), textcoords="offset points", fontsize=7
            )
        axes.set(xscale="log", yscale="log", xlabel="build, s", ylabel="f / f exact − 1")
        axes.legend()


def _draw_times(name: str, table: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "Build and picture together: the lowest bar is the setting to use."
    with plots.drawing(f"{name}_scan_times", caption, into) as axes:
        labels = [row["splits"] for row in table]
        build, trace = ([row[key] for row in table] for key in ("build_s", "trace_s"))
        axes.bar(labels, build, color="#56B4E9", label="build")
        axes.bar(labels, trace, bottom=build, color="#E69F00", label="trace")
        axes.tick_params(axis="x", labelrotation=60)
        axes.set(ylabel="s")
        axes.legend()
