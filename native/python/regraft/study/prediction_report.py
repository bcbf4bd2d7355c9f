"""`study prediction` as a section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from regraft.study import plots, prediction
from regraft.study.page import Section, Table

Row = dict[str, Any]
COLUMNS = {
    "policy": "policy",
    "measurements": "frames measured",
    "pearson": "r of C and tests",
    "pearson_low": "95 % from",
    "pearson_high": "to",
    "spearman": "rank correlation",
    "pearson_epo": "r of EPO and tests",
    "pearson_origins": "r of p_N cost and tests",
    "alpha": "best α",
    "pearson_both": "r with both",
}


def section(name: str, rows: Sequence[Row], operations: Sequence[Row]) -> Section:
    """Of one shot, from what `prediction.measure` yields."""
    table = prediction.summary(rows)
    found = Section(name, sentence(table, operations))
    found.tables.append(Table(COLUMNS, table, len(table) - 1))
    found.notes.append(
        "C is the number of tests expected of a random ray that hits the scene's box, EPO the "
        "tests that overlap causes at points on surfaces, the p_N cost the tests expected of a ray "
        "that starts anywhere in the scene's box; tests are those of the picture's rays. "
        "The predictor with both is (1−α)·C + α·EPO. Intervals come from 2,000 resamplings."
    )
    _draw(name, rows, found.plots)
    _draw_operations(name, operations, found.plots)
    return found


def sentence(table: Sequence[Row], operations: Sequence[Row]) -> str:
    """What a person should do with predictions for this shot."""
    pooled = table[-1]
    if pooled["pearson"] is None:
        return (
            "Neither predicted nor observed tests vary in this shot: there is nothing to predict."
        )
    said = (
        f"r = {pooled['pearson']:.2f} (95 %: {pooled['pearson_low']:.2f} to "
        f"{pooled['pearson_high']:.2f})"
    )
    if pooled["pearson"] >= prediction.TRUSTED:
        start = f"Predicted costs can be trusted for this shot: {said}"
    else:
        start = (
            f"Predicted costs are not to be trusted for this shot, decide by the tests that rays "
            f"need (study update): {said}"
        )
    return "; ".join([start, _of_epo(pooled), *_of_operations(operations)])


def _of_epo(pooled: Row) -> str:
    return f"with end-point overlap at α = {pooled['alpha']:.2f} it is {pooled['pearson_both']:.2f}"


def _of_operations(operations: Sequence[Row]) -> list[str]:
    kept = prediction.kept_promises(operations)
    if kept is None:
        return []
    return [f"{kept:.0%} of {len(operations)} operations saved what was promised, within 25 %"]


def _draw(name: str, rows: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = "Each point is a frame: what the tree promised and what its rays needed."
    with plots.drawing(f"{name}_prediction", caption, into) as axes:
        for i, policy in enumerate(dict.fromkeys(row["policy"] for row in rows)):
            mine = [row for row in rows if row["policy"] == policy]
            x, y = ([row[key] for row in mine] for key in ("predicted", "observed"))
            axes.plot(x, y, ".", color=plots.colour(policy, i), label=policy)
        _draw_line(axes, rows)
        if max(r["observed"] for r in rows) > 10 * min(r["observed"] for r in rows) > 0:
            plots.log_scale(axes)
        axes.set(xlabel="C, tests expected of a random ray", ylabel="tests a ray of the picture")
        axes.legend()


def _draw_line(axes: Any, rows: Sequence[Row]) -> None:
    x, y = (np.array([row[key] for row in rows]) for key in ("predicted", "observed"))
    if prediction.pearson(x, y) is None:
        return
    slope, start = np.polyfit(x, y, 1)
    ends = np.array([x.min(), x.max()])
    axes.plot(ends, start + slope * ends, color="0.5", linewidth=0.8, label="least squares")


def _draw_operations(name: str, operations: Sequence[Row], into: list[plots.Plot]) -> None:
    good = [row for row in operations if row["predicted_benefit"] > 0]
    if not good:
        return
    caption = "Each point is an operation: 1 would be a promise kept, below 0 it did harm."
    with plots.drawing(f"{name}_promises", caption, into) as axes:
        ratios = [row["realised_saving"] / row["predicted_benefit"] for row in good]
        axes.hist(np.clip(ratios, -1.0, 3.0), bins=40, color="#0072B2")
        axes.axvline(1.0, color="0.3", linewidth=0.8)
        axes.set(xlabel="saved / promised (ends hold what lies beyond)", ylabel="operations")
