"""`study image` as a section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study import image, plots
from regraft.study.page import Section, Table

Row = dict[str, Any]
COLUMNS = {
    "mode": "mode",
    "samples": "samples",
    "seconds": "seconds",
    "seconds_low": "lower quartile",
    "seconds_high": "upper quartile",
    "update_s": "of which update",
    "rmse": "RMSE",
    "relative_mse": "relMSE",
    "flip": "FLIP",
}
NAMES = {"rmse": "RMSE, linear", "relative_mse": "relMSE", "flip": "mean FLIP"}
# Errors this near to the least count as equal: then the faster one is named.
CLOSE = 1.05


def section(name: str, rows: Sequence[Row]) -> Section:
    """Of one frame, from the rows of `image.measure`."""
    floor, measured = rows[0], rows[1:]
    found = Section(name, sentence(rows))
    for error in image.ERRORS:
        _draw(name, error, floor, measured, found.plots)
    reached = image.times_to_reach(measured)
    heads = {key: key if key == "mode" else f"s to {key}" for key in reached[0]}
    found.tables += [Table(COLUMNS, rows), Table(heads, reached)]
    found.notes += [
        f"The reference has {floor['samples']:,} samples of mode {image.TRUE_MODE}; its own error "
        "(half the difference of its two halves) is the grey line, below which nothing can be "
        "told.",
        "Seconds are the update that the frame needed and the median of tracing and shading. The "
        "dashed line falls like 1/√time, as noise does.",
        "Modes that draw something else (clay, occlusion, no reflections) flatten at their bias: "
        f"RMSE {', '.join(f'{m} {image.bias(measured, m):.2g}' for m in _modes(measured))}.",
    ]
    return found


def _modes(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["mode"] for row in rows))


def sentence(rows: Sequence[Row]) -> str:
    """Which mode comes nearest for one sample, and what more samples buy."""
    floor, measured = rows[0], rows[1:]
    singles = [row for row in measured if row["samples"] == 1]
    least = min(row["flip"] for row in singles)
    best = min(
        (row for row in singles if row["flip"] <= CLOSE * least), key=lambda row: row["seconds"]
    )
    most = min(measured, key=lambda row: row["flip"])
    return (
        f"With one sample use {best['mode']}, the fastest of those nearest to the reference: "
        f"FLIP {best['flip']:.3f} in {best['seconds']:.3f} s; the nearest of all is "
        f"{most['mode']} with {most['samples']} "
        f"samples: {most['flip']:.3f} in {most['seconds']:.3f} s (the reference itself is sure to "
        f"{floor['flip']:.3f})"
    )


def _draw(name: str, error: str, floor: Row, rows: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = f"{NAMES[error]} against time, update included; 1, 2, 4, … samples."
    with plots.drawing(f"{name}_{error}", caption, into) as axes:
        for i, mode in enumerate(_modes(rows)):
            mine = [row for row in rows if row["mode"] == mode]
            x, y = ([row[key] for row in mine] for key in ("seconds", error))
            spread = [
                [max(0.0, row["seconds"] - row["seconds_low"]) for row in mine],
                [max(0.0, row["seconds_high"] - row["seconds"]) for row in mine],
            ]
            axes.errorbar(x, y, xerr=spread, marker=".", color=plots.colour(mode, i), label=mode)
        axes.axhline(floor[error], color="0.6", linewidth=1, label="the reference's own error")
        _draw_slope(axes, rows, error)
        plots.log_scale(axes, "x")
        plots.log_scale(axes)
        axes.set(xlabel="seconds", ylabel=NAMES[error])
        axes.legend()


def _draw_slope(axes: Any, rows: Sequence[Row], error: str) -> None:
    mine = [row for row in rows if row["mode"] == image.TRUE_MODE]
    first, last = mine[0]["seconds"], mine[-1]["seconds"]
    power = -1.0 if error == "relative_mse" else -0.5
    start = mine[0][error]
    ends = [start, start * (last / first) ** power]
    axes.plot([first, last], ends, "--", color="0.7", linewidth=1)
