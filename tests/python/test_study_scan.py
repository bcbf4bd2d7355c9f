"""`study scan`: errors and times are put together right, and the verdict follows from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from regraft.study import scan, scan_report
from stand_in_recording import shot_in

Row = dict[str, Any]


def test_a_scene_is_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = tuple(s for s in scan.SPLITTERS if s.label in ("exact", "k = 2", "ε = 0.3", "ε = 0"))
    monkeypatch.setattr(scan, "SPLITTERS", few)
    settings = scan.Settings(size=16, repeats=2, threads=1)
    scene = scan.scene_of(shot := shot_in(tmp_path), 1)
    ticks: list[object] = []
    rows = list(scan.measure(scene, scan.rays_of(shot, scene, 16), settings, ticks.append))
    assert len(rows) == len(ticks) == settings.steps() - 1 == 8
    assert not scan.different_hits(rows)
    table = {row["splits"]: row for row in scan.table(rows, scan.errors(scene))}
    assert list(table) == ["exact", "k = 2", "ε = 0.3", "ε = 0"]
    assert table["ε = 0"]["sam_ratio"] == pytest.approx(1.0, abs=0.01)
    assert table["ε = 0.3"]["worst_excess"] <= 0.3
    assert table["k = 2"]["mean_excess"] > table["ε = 0.3"]["mean_excess"]
    assert table["k = 2"]["sam_ratio"] > 1.0
    section = scan_report.section("hills", rows, list(table.values()))
    assert not section.wrong
    assert len(section.plots) == 2


def row(splits: str, seconds: float, ratio: float, planes: int | None = None) -> Row:
    worst = 10.0 * (ratio - 1.0)
    errors = {"worst_excess": worst, "mean_excess": worst / 10, "nodes_compared": 7}
    return {
        "splits": splits,
        "planes": planes,
        "total_s": seconds,
        "sam_ratio": ratio,
        "nodes": 100,
        **errors,
    }


def test_the_fastest_tree_that_is_as_good_is_named() -> None:
    rows = [
        row("exact", 2.0, 1.0),
        row("k = 2", 0.2, 1.5, 2),
        row("k = 8", 0.5, 1.005, 8),
        row("k = 16", 0.6, 1.001, 16),
        row("ε = 0.3", 0.4, 1.002),
    ]
    said = scan_report.sentence(rows)
    assert "Use ε = 0.3: its tree and picture take 20% of the time with exact splits" in said
    assert "the tree costs 1.002× as much" in said
    assert "k = 8 is the least that is as good, with errors up to 5.0% at single nodes" in said
    rows[-1]["total_s"] = 1.0
    said = scan_report.sentence(rows)
    assert "Use k = 8: its tree and picture take 25%" in said
    assert "the default, ε = 0.3, takes 50% for 1.002× the cost" in said


def test_trees_that_hit_other_things_are_the_verdict() -> None:
    rows = [{"splits": "exact", "hits": "a"}, {"splits": "k = 2", "hits": "b"}]
    assert scan.different_hits(rows) == ["k = 2"]
