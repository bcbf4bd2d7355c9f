"""`regraft bench numpy`: what is raced, and how it is laid out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from regraft.cli import bench_numpy, main

MACHINE = {
    "processor": "p",
    "cores": 2,
    "simd": "avx2",
    "load_average": 0.1,
    "regraft": "1",
    "commit": "",
}


def row(contender: str, count: int, seconds: float) -> dict[str, Any]:
    return {"rays": "picture", "contender": contender, "count": count, "seconds": seconds}


def test_our_best_is_set_against_each_peer() -> None:
    rows = [
        row("regraft 1", 1_000_000, 1.0),
        row("regraft 2", 1_000_000, 0.5),
        row("BVHTree", 20_000, 0.2),
        row("embreex", 1_000_000, 0.8),
    ]
    lines = list(bench_numpy.table({**MACHINE, "triangles": 9, "rays": 1_000_000, "rows": rows}))
    assert lines[-1].split() == ["picture", "1.00", "2.00", "0.10", "1.25", "20.00", "1.60"]


def test_all_contenders_shoot_the_same_rays() -> None:
    seen: dict[str, list[int]] = {"all": [], "few": []}

    def shoot(name: str) -> Any:
        def count(origins: Any, _directions: Any) -> int:
            seen[name].append(len(origins))
            return 7

        return count

    rays = bench_numpy.Rays("some", np.zeros((100, 3), np.float32), np.ones((100, 3), np.float32))
    contenders = [
        bench_numpy.Contender("all", shoot("all")),
        bench_numpy.Contender("few", shoot("few"), most=10),
    ]
    rows = list(bench_numpy.race(rays, contenders, 3))
    assert seen == {"all": [100] * 3, "few": [10] * 3}
    assert [(r["count"], r["hits"]) for r in rows] == [(100, 7), (10, 7)]


def test_the_few_rays_of_a_contender_are_spread_over_all() -> None:
    kept: list[Any] = []

    def keep(origins: Any, _directions: Any) -> int:
        kept.append(origins)
        return 0

    origins = np.arange(300, dtype=np.float32).reshape(100, 3)
    rays = bench_numpy.Rays("some", origins, origins)
    few = bench_numpy.Contender("few", keep, most=10)
    list(bench_numpy.race(rays, [few], 1))
    assert np.array_equal(kept[0], origins[::10])


def test_the_command_measures_and_writes_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "bench.json"
    words = ["--triangles", "200", "--rays", "400", "--rounds", "1", "--output", str(output)]
    assert main(["bench", "numpy", *words]) == 0
    result = json.loads(output.read_text())
    assert {r["rays"] for r in result["rows"]} == {"picture", "picture, any order", "everywhere"}
    hits = {r["hits"] for r in result["rows"] if r["rays"].startswith("picture")}
    assert len(hits) == 1, "a picture has as many hits in any order and by any contender"
    assert "/ BVHTree" in capsys.readouterr().out
