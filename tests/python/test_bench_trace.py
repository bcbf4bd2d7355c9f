"""`regraft bench trace`: reads what the native program measures and lays it out."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import bench_trace
from regraft.cli.errors import InputError, SelfCheckError

MACHINE = {
    "processor": "p",
    "cores": 2,
    "simd": "avx2",
    "load_average": 0.1,
    "regraft": "1",
    "commit": "",
}
SETTINGS = {"image": 64, "rounds": 1, "threads": 1, "scene": "balls 1M"}


def row(contender: str, rate: float, rays: str = "primary") -> dict[str, Any]:
    """A measurement of `rate` million rays a second."""
    return {
        "scene": "balls 1M",
        "triangles": 1000,
        "rays": rays,
        "count": 4096,
        "contender": contender,
        "median_ms": 4096 / rate / 1e3,
        "hits": 99,
    }


def program(folder: Path, rows: list[dict[str, Any]], code: int = 0) -> Path:
    """A program that writes `rows` where it is told, with its options beside them, or fails."""
    path = folder / "program"
    path.write_text(
        f"#!{sys.executable}\nimport json, sys\nprint('why', file=sys.stderr)\n"
        f"rows = json.loads({json.dumps(rows)!r})\n"
        "at = sys.argv.index('--json')\n"
        "options = sys.argv[1:at] + sys.argv[at + 2:]\n"
        "with open(sys.argv[at + 1], 'w') as file:\n"
        "    json.dump({'lines': rows + [{'options': options}]}, file)\n"
        f"sys.exit({code})\n"
    )
    path.chmod(0o755)
    return path


def test_rows_are_what_the_program_writes_when_asked_as_the_user_asked(tmp_path: Path) -> None:
    rows = [row("regraft packets", 8.0), row("embree robust static 16", 10.0)]
    found = bench_trace.measure(program(tmp_path, rows), SETTINGS)
    assert found[:-1] == rows
    options = found[-1]["options"]
    assert dict(zip(options[::2], options[1::2], strict=True)) == {
        "--image": "64",
        "--rounds": "1",
        "--threads": "1",
        "--scene": "balls 1M",
    }


def test_a_missing_program_says_how_to_build_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="make bench"):
        bench_trace.measure(tmp_path / "none", SETTINGS)


def test_a_failing_program_is_an_error_with_its_words(tmp_path: Path) -> None:
    with pytest.raises(SelfCheckError, match="failed with 3: why"):
        bench_trace.measure(program(tmp_path, [], 3), SETTINGS)


def test_our_best_is_set_against_the_best_robust_peer() -> None:
    rows = [
        row("regraft packets", 8.0),
        row("regraft single", 2.0),
        row("embree robust static 16", 10.0),
        row("embree robust dynamic 8", 9.0),
        row("embree fast static 16", 16.0),
    ]
    last = list(bench_trace.table({**MACHINE, "rows": rows}))[-1]
    assert last.split() == ["balls", "1M", "primary", "8.00", "2.00", "10.00", "16.00", "0.80"]


def test_without_a_peer_there_is_no_ratio() -> None:
    rows = [row("regraft packets", 8.0), row("regraft single", 2.0)]
    last = list(bench_trace.table({**MACHINE, "rows": rows}))[-1]
    assert last.split()[3:] == ["8.00", "2.00", "–", "–", "–"]
