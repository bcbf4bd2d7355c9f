"""`study update` as a section of a page: verdict, four plots, a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study import plots, update, update_verdict
from regraft.study.page import Section, Table

Row = dict[str, Any]
COLUMNS = {
    "label": "policy",
    "total_s": "total s",
    "update_s": "update s",
    "trace_s": "trace s",
    "update_share": "update / rebuilding's",
    "speed_up": "× as fast as rebuilding",
    "ratio_median": "tests / fresh tree's, median",
    "ratio_worst": "worst",
    "worst_frame": "at frame",
    "enough_until": "enough until frame",
    "total_s_low": "total s, lower quartile",
    "total_s_high": "upper quartile",
    "pairs_considered": "pairs seen",
    "pairs_restructured": "pairs mended",
    "nodes_refitted": "nodes refitted",
    "nodes_rebuilt": "nodes rebuilt",
    "first_update_ms": "first update ms",
    "given_up_after": "given up after frame",
}
# Ratios beyond this are drawn on a logarithmic axis.
LARGE = 3.0


def section(name: str, rows: Sequence[Row]) -> Section:
    """Of one shot, from the rows of `update.measure`."""
    frames, totals = update.by_frame(rows), update.totals(rows)
    chosen = totals.index(update_verdict.choose(totals))
    found = Section(name, *verdict(rows, totals))
    found.tables.append(Table(COLUMNS, totals, chosen))
    found.notes += notes(rows, totals)
    _draw(name, frames, totals, found.plots)
    return found


def verdict(rows: Sequence[Row], totals: Sequence[Row]) -> tuple[str, bool]:
    """A sentence, and whether it says that something is not as it must be."""
    wrong = update.different_hits(rows)
    if not wrong:
        return update_verdict.sentence(totals), False
    return (
        "The policies do not agree: in frame "
        f"{wrong[0]['frame']} {update.label(wrong[0])} hits other things than the first policy "
        f"({len(wrong)} of {len(rows)} measurements differ). Please report this scene."
    ), True


def notes(rows: Sequence[Row], totals: Sequence[Row]) -> list[str]:
    """How to read the figures."""
    repeats, frames = 1 + max(row["repeat"] for row in rows), update.yardstick(totals)["frames"]
    said = [
        f"Times are medians of {repeats} replays of the shot, each on fresh scenes, the policies "
        f"taking turns frame by frame; {frames} frames count, the first, which "
        " builds everything, is stated apart. Counts do not depend on the machine.",
        "The quality of a tree is the number of tests that the picture's rays needed, beside those "
        "they needed in a tree just built for the same frame; enough is at most "
        f"{update.ENOUGH:g} times as many.",
        "Distances, triangles and shadows of all policies are compared bit for bit in every frame "
        "and replay.",
    ]
    if gone := [row["label"] for row in totals if row["given_up_after"] is not None]:
        said.append(
            f"Given up for taking more than {update.HOPELESS:g} times as long as rebuilding: "
            f"{', '.join(gone)}; their seconds are those up to there."
        )
    if unsteady := update.unsteady_counts(rows):
        said.append(f"The work of {', '.join(unsteady)} differed from replay to replay.")
    return said


def _draw(name: str, frames: Sequence[Row], totals: Sequence[Row], into: list[plots.Plot]) -> None:
    _draw_ratio(name, "ratio", frames, into)
    _draw_ratio(name, "predicted_ratio", frames, into)
    _draw_front(name, totals, into)
    _draw_totals(name, totals, into)
    _draw_cumulative(name, frames, into)


_CAPTIONS = {
    "ratio": "How trees age: tests of the picture's rays, beside those in a tree just built.",
    "predicted_ratio": "What the surface area heuristic says of it: tests expected of a random ray "
    "that hits the scene's box, beside those in a tree just built.",
}


def _draw_ratio(name: str, key: str, frames: Sequence[Row], into: list[plots.Plot]) -> None:
    rated = [row for row in frames if row[key] is not None]
    with plots.drawing(f"{name}_{key}", _CAPTIONS[key], into) as axes:
        plots.lines(axes, _series(rated, lambda row: row[key]))
        axes.axhline(update.ENOUGH, color="0.6", linewidth=0.8, linestyle=":")
        if any(row[key] > LARGE for row in rated):
            plots.log_scale(axes)
        axes.set(xlabel="frame", ylabel="tests / fresh tree's")


def _draw_front(name: str, totals: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "What a better tree costs: nothing beats the policies on the grey line in both."
    with plots.drawing(f"{name}_front", caption, into) as axes:
        rated = [row for row in totals if row["ratio_median"] is not None]
        points = {row["label"]: (row["update_s"], row["ratio_median"]) for row in rated}
        plots.scatter(axes, points)
        if any(ratio > LARGE for _, ratio in points.values()):
            plots.log_scale(axes)
        axes.set(xlabel="update, seconds in all", ylabel="tests / fresh tree's, median")


def _draw_totals(name: str, totals: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "Update and trace in all; the bars' whiskers are quartiles over the replays."
    with plots.drawing(f"{name}_total", caption, into) as axes:
        names = [row["label"] for row in totals]
        updates = [row["update_s"] for row in totals]
        axes.barh(names, updates, color="#D55E00", label="update")
        axes.barh(names, [r["trace_s"] for r in totals], left=updates, color="0.7", label="trace")
        for row in totals:
            if row["given_up_after"] is not None:
                words = f" given up after frame {row['given_up_after']}"
                axes.text(row["total_s"], row["label"], words, va="center", fontsize=8)
        low = [max(0.0, row["total_s"] - row["total_s_low"]) for row in totals]
        high = [max(0.0, row["total_s_high"] - row["total_s"]) for row in totals]
        sums = [row["total_s"] for row in totals]
        axes.errorbar(sums, names, xerr=[low, high], fmt="none", ecolor="0.2", capsize=2)
        axes.invert_yaxis()
        axes.set(xlabel="seconds in all")
        axes.legend()


def _draw_cumulative(name: str, frames: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "Update and trace up to each frame, after the first."
    with plots.drawing(f"{name}_cumulative", caption, into) as axes:
        first = min(row["frame"] for row in frames)
        series = _series(
            [row for row in frames if row["frame"] != first],
            lambda row: (row["update_ms"] + row["trace_ms"]) / 1e3,
        )
        sums = {k: (x, [sum(y[: i + 1]) for i in range(len(y))]) for k, (x, y) in series.items()}
        plots.lines(axes, sums)
        axes.set(xlabel="frame", ylabel="seconds")


def _series(rows: Sequence[Row], value: Any) -> dict[str, tuple[list[float], list[float]]]:
    found: dict[str, tuple[list[float], list[float]]] = {}
    for row in rows:
        x, y = found.setdefault(update.label(row), ([], []))
        x.append(row["frame"])
        y.append(value(row))
    return found
