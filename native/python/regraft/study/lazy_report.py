"""`study lazy` as a section of a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from regraft.study import lazy, plots
from regraft.study.page import Section, Table

Row = dict[str, Any]
COLUMNS = {
    "axis": "what varies",
    "zoom": "window ×",
    "copies": "copies of the scene",
    "triangles": "triangles",
    "triangles_seen": "seen",
    "nodes_opened": "k-d nodes made",
    "built_fraction": "of the tree built",
    "kdtree_first_ms": "first picture, k-d tree, ms",
    "bvh_first_ms": "BVH, ms",
    "kdtree_again_ms": "next picture, k-d tree, ms",
    "bvh_again_ms": "BVH, ms",
}


def section(name: str, rows: Sequence[Row]) -> Section:
    """Of one scene, from the rows of `lazy.measure`."""
    found = Section(name, sentence(rows))
    found.tables.append(Table(COLUMNS, rows))
    found.notes.append(
        f"Medians of {lazy.REPEATS} scenes made anew. The first picture holds building and "
        "tracing; the next one finds what it needs built. Seen: the camera's window is narrowed; "
        "hidden: copies of the scene stand behind the eye."
    )
    _draw(name, rows, "seen", "triangles_seen", found.plots)
    _draw(name, rows, "hidden", "triangles", found.plots)
    return found


def sentence(rows: Sequence[Row]) -> str:
    """Which structure a first picture wants, and how its work grows."""
    whole, near = (
        rows[0],
        min((row for row in rows if row["axis"] == "seen"), key=lambda row: row["zoom"]),
    )
    if whole["nodes_opened"] == 0:
        return "This scene has nothing that can be hit."
    use = "kdtree" if near["kdtree_first_ms"] < near["bvh_first_ms"] else "bvh"
    parts = [
        f"For one near picture use structure {use}: the k-d tree takes "
        f"{near['kdtree_first_ms']:.0f} ms and the BVH {near['bvh_first_ms']:.0f} ms",
        f"for the whole view it is {whole['kdtree_first_ms']:.0f} against "
        f"{whole['bvh_first_ms']:.0f} ms",
    ]
    return "; ".join([*parts, *_growth(rows)])


def _growth(rows: Sequence[Row]) -> list[str]:
    said = []
    for axis, x, words in (
        ("seen", "triangles_seen", "with the triangles seen"),
        ("hidden", "triangles", "with hidden ones"),
    ):
        mine = [row for row in rows if row["axis"] == axis]
        power = lazy.slope(mine, x, "nodes_opened")
        if power is not None:
            said.append(f"nodes made grow like n^{power:.2f} {words}")
    return said


def _draw(name: str, rows: Sequence[Row], axis: str, x: str, into: list[plots.Plot]) -> None:
    mine = sorted((row for row in rows if row["axis"] == axis), key=lambda row: row[x])
    caption = f"Nodes made and first picture, against triangles {axis}."
    with plots.drawing(f"{name}_lazy_{axis}", caption, into) as axes:
        across = [row[x] for row in mine]
        series = {
            "nodes made / 100": (across, [row["nodes_opened"] / 100 for row in mine]),
            "k-d tree": (across, [row["kdtree_first_ms"] for row in mine]),
            "bvh": (across, [row["bvh_first_ms"] for row in mine]),
        }
        plots.lines(axes, series)
        plots.log_scale(axes, "x")
        plots.log_scale(axes)
        axes.set(xlabel=f"triangles {axis}", ylabel="ms to the first picture")
