"""`study lazy`: what is seen and hidden is counted right, and growth is fitted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from regraft.study import lazy, lazy_report
from stand_in_recording import TRIANGLES, shot_in

Row = dict[str, Any]


def test_slopes_are_those_of_powers() -> None:
    rows = [{"x": x, "y": 3.0 * x**0.7} for x in (1, 10, 100, 1000)]
    assert lazy.slope(rows, "x", "y") == pytest.approx(0.7)
    assert lazy.slope([{"x": 5, "y": y} for y in (1, 2)], "x", "y") is None
    assert lazy.slope([{"x": 0, "y": 1}], "x", "y") is None


def row(axis: str, zoom: float, copies: int, **more: Any) -> Row:
    seen = {"triangles": 1000 * copies, "triangles_seen": int(1000 * zoom)}
    times = {"kdtree_first_ms": 100.0 * zoom, "bvh_first_ms": 50.0}
    return {
        "axis": axis,
        "zoom": zoom,
        "copies": copies,
        "nodes_opened": 100,
        **seen,
        **times,
    } | more


def test_the_verdict_names_the_structure_for_a_near_picture() -> None:
    rows = [row("seen", zoom, 1, nodes_opened=int(1000 * zoom)) for zoom in (1.0, 0.25)]
    rows += [row("hidden", 0.5, copies) for copies in (1, 8)]
    said = lazy_report.sentence(rows)
    assert "use structure kdtree: the k-d tree takes 25 ms and the BVH 50 ms" in said
    assert "for the whole view it is 100 against 50 ms" in said
    assert "grow like n^1.00 with the triangles seen" in said
    assert "grow like n^0.00 with hidden ones" in said or "n^-0.00 with hidden" in said


def test_a_scene_is_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lazy, "REPEATS", 1)
    rows = list(lazy.measure(shot_in(tmp_path), 24, 1, lambda _: None))
    assert len(rows) == lazy.steps()
    assert min(r["bvh_nodes"] for r in rows) > 100, "the BVH's first picture builds it"
    seen = [r for r in rows if r["axis"] == "seen"]
    hidden = [r for r in rows if r["axis"] == "hidden"]
    assert np.all(np.diff([r["triangles_seen"] for r in seen[1:]]) < 0)
    assert np.all(np.diff([r["nodes_opened"] for r in seen]) < 0)
    assert [r["triangles"] for r in hidden] == [c * seen[0]["triangles"] for c in lazy.COPIES]
    assert abs(seen[0]["triangles"] - TRIANGLES) < 0.1 * TRIANGLES
    assert np.ptp([r["triangles_seen"] for r in hidden]) <= 2, "what is behind the eye is hidden"
    assert hidden[-1]["nodes_opened"] < 1.1 * hidden[0]["nodes_opened"]
