"""`study stability` as a section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study import plots, stability
from regraft.study.page import Section, Table

Row = dict[str, Any]
COLUMNS = {
    "axis": "what",
    "setting": "setting",
    "structure": "structure",
    "layout": "layout",
    "policy": "policy",
    "hits": "hits",
    "worst_ulps": "worst error of t, ulps",
    "median_ulps": "median",
    "other_triangles": "other triangles",
    "pixels_changed": "pixels changed",
    "differ_from_brute_force": "differ from brute force",
}
WORDS = {
    "offset": "an offset of {0} × its size",
    "scale": "a scale of {0}",
    "aspect": "a stretch of {0} along x and 1/{0} along z",
}


def section(name: str, rows: Sequence[Row]) -> Section:
    """Of one scene, from the rows of `stability.measure` and `measure_steps`."""
    verdict, wrong = sentence(rows)
    found = Section(name, verdict, wrong)
    found.tables.append(Table(COLUMNS, [{**row, "setting": setting(row)} for row in rows]))
    found.notes += [
        "An ulp is that of the largest coordinate of ray and triangle where the setting puts them; "
        "the error is taken across the triangle's plane, in double precision. Up to 16 are due "
        "to rounding.",
        "A pixel has changed if its brightness, lit from the eye, differs by more than 1/255.",
        "Time steps exaggerate all motion away from the first frame; errors are the worst of "
        f"{stability.MOST_LOOKS} frames among the first {stability.MOST_FRAMES}.",
    ]
    for axis in dict.fromkeys(row["axis"] for row in rows):
        _draw(name, axis, [row for row in rows if row["axis"] == axis], found.plots)
    return found


def setting(row: Row) -> str:
    """A setting as people write it."""
    if row["axis"] == "time step":
        return f"× {row['exponent']:g}"
    return f"{2.0 ** row['exponent']:.3g}"


def sentence(rows: Sequence[Row]) -> tuple[str, bool]:
    """The verdict, and whether it says that something is not as it must be."""
    if wrong := [row for row in rows if row["differ_from_brute_force"]]:
        row = wrong[0]
        return (
            f"Rays are answered wrongly: at {row['axis']} {setting(row)} "
            f"({_way(row)}) {row['differ_from_brute_force']} rays differ from brute force. "
            "Please report this scene."
        ), True
    worst = max((row["worst_ulps"] or 0.0) for row in rows)
    said = [_of_axis(rows, axis) for axis in stability.EXPONENTS]
    return (
        f"{'; '.join(said)}; the worst error of any distance is {worst:.3g} ulps, and no ray "
        "differs from brute force"
    ), False


def _of_axis(rows: Sequence[Row], axis: str) -> str:
    first = stability.first_change(rows, axis)
    if first is None:
        furthest = max(abs(e) for e in stability.EXPONENTS[axis])
        return f"{axis}: the picture keeps every pixel, up to {2.0**furthest:.3g}"
    words = WORDS[axis].format(setting(first))
    return (
        f"{axis}: the first picture to change by more than 1/255 is at {words} "
        f"({first['pixels_changed']} pixels, {_way(first)})"
    )


def _way(row: Row) -> str:
    return " ".join(str(row[k]) for k in ("structure", "layout", "policy") if k in row)


def _draw(name: str, axis: str, rows: Sequence[Row], into: list[plots.Plot]) -> None:
    caption = f"{axis.capitalize()}: the worst error of t."
    with plots.drawing(f"{name}_{axis.replace(' ', '_')}", caption, into) as axes:
        series: dict[str, tuple[list[float], list[float]]] = {}
        for row in rows:
            if row["worst_ulps"] is not None:
                x, y = series.setdefault(_series(row), ([], []))
                x.append(row["exponent"])
                y.append(max(row["worst_ulps"], 1e-3))
        plots.lines(axes, series)
        plots.log_scale(axes)
        what = "time step, times" if axis == "time step" else f"{axis}, power of two"
        axes.set(xlabel=what, ylabel="worst error, ulps")


def _series(row: Row) -> str:
    return row["policy"] if row["axis"] == "time step" else f"{row['structure']} {row['layout']}"
