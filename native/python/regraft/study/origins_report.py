"""`study origins` as a section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study import origins, plots
from regraft.study.page import Section, Table

Row = dict[str, Any]
# A saving below this is none.
_WORTH = 0.005
COLUMNS = {
    "metric": "split by",
    "rays": "rays",
    "count": "number",
    "nodes_visited": "nodes visited",
    "triangle_tests": "triangle tests",
    "cost_ratio": "cost / sah",
    "trace_s": "trace, s",
    "build_s": "build, s",
    "nodes": "nodes built",
}


def section(name: str, room: origins.Room, rows: Sequence[Row], table: Sequence[Row]) -> Section:
    """Of one scene, from the rows of `origins.measure` and their `origins.table`."""
    wrong = list(dict.fromkeys(origins.different_hits(rows)))
    verdict = sentence(table, room.chosen)
    if wrong:
        verdict = f"Rays in trees split by {', '.join(wrong)} hit other things."
    found = Section(name, verdict, bool(wrong))
    found.tables.append(Table(COLUMNS, table, table.index(recommended(table))))
    low, high = (" × ".join(f"{x:.4g}" for x in corner) for corner in room.box)
    found.notes += [
        f"Cost: nodes visited + {origins.TEST:g} × triangle tests. Build: what the first pass of "
        "all rays took more than the second; only what they need is built.",
        "Light inside: in the middle of the scene's box; outside: two sizes away.",
        f"p_N supposes rays that start between {low} and {high}.",
    ]
    _draw(name, table, found.plots)
    _draw_builds(name, table, found.plots)
    return found


def recommended(table: Sequence[Row]) -> Row:
    """Of the metrics that are as fast to compute, the row for all rays with the least cost; the
    surface area heuristic unless another saves something."""
    sah, other = (_of(table, metric) for metric in origins.CHEAP)
    return other if other["cost_ratio"] < 1.0 - _WORTH else sah


def _of(table: Sequence[Row], metric: str, rays: str = origins.ALL) -> Row:
    return next(row for row in table if (row["metric"], row["rays"]) == (metric, rays))


def sentence(table: Sequence[Row], chosen: str) -> str:
    """By which metric to split, and what it saves which rays."""
    best = recommended(table)
    if not best["cost"]:
        return "No ray of this scene visits anything."
    metric = best["metric"] if best["metric"] != origins.SAH else origins.CHEAP[1]
    changes = ", ".join(
        f"{row['rays']} {row['cost_ratio'] - 1:+.1%}"
        for row in table
        if row["metric"] == metric and row["rays"] != origins.ALL
    )
    of_all = _of(table, metric)["cost_ratio"] - 1
    start = f"Split by {best['metric']}"
    what = f"{metric} changes the cost of all rays by {of_all:+.1%} ({changes})"
    rule = (
        "so does the library of itself"
        if chosen == best["metric"]
        else f"of itself the library would take {chosen}, by where rays start"
    )
    return "; ".join([f"{start}: {what}", rule, *_dearer(table, best)])


def _dearer(table: Sequence[Row], best: Row) -> list[str]:
    others = [_of(table, m) for m in origins.METRICS if m not in origins.CHEAP]
    least = min(others, key=lambda row: row["cost"])
    if least["cost_ratio"] > best["cost_ratio"] - _WORTH:
        return ["no dearer metric is better"]
    slower = least["build_s"] / max(best["build_s"], 1e-9)
    change = f"{least['cost_ratio'] - 1:+.1%}"
    return [f"{least['metric']} changes it by {change} but builds {slower:.1f}× as long"]


def _draw(name: str, table: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "Cost of rays in each metric's tree over that in the tree of the area heuristic."
    with plots.drawing(f"{name}_origins", caption, into) as axes:
        kinds = list(dict.fromkeys(row["rays"] for row in table))
        width = 0.8 / len(origins.METRICS)
        for i, metric in enumerate(origins.METRICS):
            heights = [_of(table, metric, kind)["cost_ratio"] for kind in kinds]
            x = [k + (i - 2) * width for k in range(len(kinds))]
            axes.bar(x, heights, width, color=plots.colour(metric, i), label=metric)
        axes.set_xticks(range(len(kinds)), kinds, rotation=15)
        low = min(row["cost_ratio"] for row in table)
        high = max(row["cost_ratio"] for row in table)
        axes.set(ylabel="cost / cost with sah", ylim=(max(0.0, low - 0.05), high + 0.05))
        axes.axhline(1.0, color="0.3", linewidth=0.8)
        axes.legend(ncols=3)


def _draw_builds(name: str, table: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "What a metric's tree takes to build, and what its rays then take."
    with plots.drawing(f"{name}_origins_times", caption, into) as axes:
        rows = [_of(table, metric) for metric in origins.METRICS]
        labels = [row["metric"] for row in rows]
        build, trace = ([row[key] for row in rows] for key in ("build_s", "trace_s"))
        axes.bar(labels, build, color="#56B4E9", label="build")
        axes.bar(labels, trace, bottom=build, color="#E69F00", label="trace")
        axes.set(ylabel="s")
        axes.legend()
