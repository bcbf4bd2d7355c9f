"""`study origins`: rays of every kind are counted, and the verdict follows from the counts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import regraft
from regraft.study import origins, origins_report
from regraft.study.stability import Rays
from stand_in_recording import shot_in

Row = dict[str, Any]
KINDS = ("primary", "shadow, light inside", "shadow, light outside", "reflection")


def test_rays_go_where_they_should() -> None:
    scene = regraft.Scene(threads=1)
    floor = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    scene.add_instance(scene.add_mesh(floor, np.array([[0, 1, 2], [0, 2, 3]], np.uint32)))
    scene.update(structure="kdtree")
    slanting = Rays(np.array([[-0.5, 0.1, 1.0]]), np.array([[1.0, 0.0, -1.0]]))
    sets = origins.ray_sets(scene, slanting, scene.bounds())
    assert [s.name for s in sets] == list(KINDS)
    inside, outside = origins.lights(scene.bounds())
    for rays, light in ((sets[1].rays, inside), (sets[2].rays, outside)):
        assert rays.origins[0] == pytest.approx([0.5, 0.1, 0.0], abs=1e-3)
        assert rays.origins[0] + rays.directions[0] == pytest.approx(light)
    assert sets[3].rays.directions[0] == pytest.approx([1.0, 0.0, 1.0])


def test_a_scene_is_measured(tmp_path: Path) -> None:
    room = origins.room_of(shot_in(tmp_path), 8, 1)
    ticks: list[object] = []
    rows = list(origins.measure(room, origins.Settings(size=8, repeats=1), ticks.append))
    assert len(ticks) == len(origins.METRICS)
    assert len(rows) == len(origins.METRICS) * len(KINDS)
    assert not origins.different_hits(rows)
    table = origins.table(rows)
    for row in table:
        cost = row["nodes_visited"] + origins.TEST * row["triangle_tests"]
        assert row["cost"] == pytest.approx(cost)
        if row["metric"] == "sah":
            assert row["cost_ratio"] == 1.0
    of_all = next(row for row in table if row["rays"] == origins.ALL)
    assert of_all["count"] == sum(row["count"] for row in rows if row["metric"] == "sah")
    section = origins_report.section("hills", room, rows, table)
    assert section.verdict.startswith("Split by ")
    assert len(section.plots) == 2


def table_of(**costs: float) -> list[Row]:
    return [
        {"metric": m, "rays": r, "cost": 100 * c, "cost_ratio": c, "build_s": 1.0}
        for m in origins.METRICS
        for r, c in (("primary", costs.get(m, 1.0)), (origins.ALL, costs.get(m, 1.0)))
    ]


def test_the_metric_that_saves_is_named() -> None:
    said = origins_report.sentence(table_of(regions6=0.96), "regions6")
    assert said.startswith("Split by regions6: regions6 changes the cost of all rays by -4.0%")
    assert "so does the library of itself; no dearer metric is better" in said
    said = origins_report.sentence(table_of(regions6=1.02, exact=0.9), "regions6")
    assert said.startswith("Split by sah: regions6 changes the cost of all rays by +2.0%")
    assert "of itself the library would take regions6" in said
    assert "exact changes it by -10.0% but builds 1.0× as long" in said


def test_hits_that_differ_are_found() -> None:
    rows = [
        {"metric": m, "rays": "primary", "hits": h, "is_same": True}
        for m, h in (("sah", "a"), ("exact", "b"))
    ]
    assert origins.different_hits(rows) == ["exact"]
