"""`regraft bench kdtree`: reads what the native program measures and lays it out."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import bench_kdtree
from regraft.cli.errors import InputError, SelfCheckError

WAYS = ("eager", "lazy", "scan", "lazy+scan", "hierarchy", "lazy+scan+hierarchy")

MACHINE = {
    "processor": "p",
    "cores": 2,
    "simd": "avx2",
    "load_average": 0.1,
    "regraft": "1",
    "commit": "",
}


def row(kind: str, configuration: str, build: float, **more: Any) -> dict[str, Any]:
    return {
        "kind": kind,
        "scene": "courtyard",
        "view": "near",
        "triangles": 1000,
        "visible": 10,
        "configuration": configuration,
        "build_s": build,
        "trace_s": 0.05,
        "trace_singly_s": 0.15,
        "nodes": 7,
        "unbuilt": 0,
        "large_leaves": 1,
        "quality": 0.75,
        "nodes_visited": 99,
        **more,
    }


def program(folder: Path, text: str, code: int = 0) -> Path:
    """A program that prints `text`, and fails with `code`."""
    path = folder / "program"
    path.write_text(
        f"#!{sys.executable}\nimport sys\nprint({text!r})\nprint('why', file=sys.stderr)\n"
        f"sys.exit({code})\n"
    )
    path.chmod(0o755)
    return path


def test_rows_are_what_the_program_prints(tmp_path: Path) -> None:
    rows = [row("table", way, 0.1) for way in WAYS]
    text = "\n".join(json.dumps(r) for r in rows)
    assert list(bench_kdtree.measure(program(tmp_path, text), "20000")) == rows


def test_a_missing_program_says_how_to_build_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="make bench"):
        list(bench_kdtree.measure(tmp_path / "none", "20000"))


def test_a_failing_program_is_an_error_with_its_words(tmp_path: Path) -> None:
    with pytest.raises(SelfCheckError, match="failed with 3: why"):
        list(bench_kdtree.measure(program(tmp_path, "", 3), "20000"))


def test_the_exponent_is_the_power_that_build_time_grows_with() -> None:
    rows = [row("growth_eager", "x", 1e-6 * n**1.5, triangles=n) for n in (10, 100, 5000)]
    rows += [row("growth_visible", "x", 2e-3, visible=v) for v in (10, 100)]
    rows += [row("growth_hidden", "x", 1.0)]
    found = bench_kdtree.exponents(rows)
    assert found["growth_eager"] == pytest.approx(1.5)
    assert found["growth_visible"] == pytest.approx(0.0)
    assert "growth_hidden" not in found


def test_the_table_sets_every_way_beside_the_best() -> None:
    rows = [row("table", way, 0.5 * (6 - i)) for i, way in enumerate(WAYS)]
    rows += [row("growth_eager", "hierarchy", 0.1 * n, triangles=n) for n in (10, 20)]
    result = {**MACHINE, "rows": rows, "exponents": bench_kdtree.exponents(rows)}
    lines = list(bench_kdtree.table(result))
    eager = next(line for line in lines if line.startswith("eager"))
    assert eager.split() == [
        *("eager", "3.0000", "6.0", "0.0500", "0.1500", "7", "0", "1", "0.750", "99")
    ]
    assert any("courtyard, near: n = 1000, v = 10" in line for line in lines)
    assert any("grows with its 1.00th power" in line for line in lines)


def test_the_metrics_are_set_against_areas() -> None:
    def origins(metric: str, visits: int) -> dict[str, Any]:
        more = {"metric": metric, "rays": "primary", "triangle_tests": 10, "nodes_visited": visits}
        return row("origins", "", 2.0, **more)

    rows = [origins("sah", 200), origins("regions6", 150)]
    result = {**MACHINE, "rows": rows, "exponents": {}}
    lines = list(bench_kdtree.table(result))
    assert any("courtyard, primary" in line for line in lines)
    assert lines[-1].split() == ["regions6", "-25.0", "%", "+0.0", "%", "+0.0", "%", "2.00"]


def test_quality_is_told_of_whole_trees_of_more_than_one_triangle() -> None:
    rows = [row("table", way, 0.1, quality=None, unbuilt=0) for way in WAYS[:-1]]
    rows += [row("table", WAYS[-1], 0.1, quality=0.7, unbuilt=5)]
    lines = list(bench_kdtree.table({**MACHINE, "rows": rows, "exponents": {}}))
    assert [line.split()[8] for line in lines[-len(WAYS) :]] == ["–"] * len(WAYS)
